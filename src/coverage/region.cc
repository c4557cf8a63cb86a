#include "colmap_ext/coverage/region.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "colmap_ext/util/error.h"
#include "coverage/convex_hull.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMinPoints = 10;
constexpr double kLowPercentile = 0.005;
constexpr double kHighPercentile = 0.995;
constexpr double kGroundPercentile = 0.05;

struct WeightedPoint {
  Eigen::Vector3d position;
  double weight = 1;
};

// Smallest coordinate below which at least `part` of the weight lies.
double Percentile(const std::vector<WeightedPoint>& points, int axis, double part) {
  std::vector<std::pair<double, double>> sorted;
  sorted.reserve(points.size());
  for (const WeightedPoint& point : points) sorted.emplace_back(point.position[axis], point.weight);
  std::sort(sorted.begin(), sorted.end());
  double total = 0;
  for (const auto& [coordinate, weight] : sorted) total += weight;
  double sum = 0;
  for (const auto& [coordinate, weight] : sorted) {
    sum += weight;
    if (sum >= part * total) return coordinate;
  }
  return sorted.back().first;
}

BoundingBox PercentileBounds(const std::vector<WeightedPoint>& points) {
  BoundingBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min()[axis] = Percentile(points, axis, kLowPercentile);
    box.max()[axis] = Percentile(points, axis, kHighPercentile);
  }
  return box;
}

// Hull of the camera centres, drawn in by a tenth: what the cameras fly along (the walls of a room)
// is not what they fly around.
std::vector<Eigen::Vector2d> HullOfFlight(const std::vector<PosedPhoto>& photos) {
  constexpr double kShrink = 0.9;
  std::vector<Eigen::Vector2d> centers;
  for (const PosedPhoto& photo : photos) {
    centers.emplace_back(CameraCenter(photo.cam_from_world).head<2>());
  }
  std::vector<Eigen::Vector2d> hull = ConvexHull(std::move(centers));
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : hull) middle += corner / static_cast<double>(hull.size());
  for (Eigen::Vector2d& corner : hull) corner = middle + kShrink * (corner - middle);
  return hull;
}

// Points in the hull of the camera centres; empty when these are too few to go by.
std::vector<WeightedPoint> PointsInsideFlight(const PhotoSet& photos) {
  constexpr double kMinPartInside = 0.1;
  const std::vector<Eigen::Vector2d> hull = HullOfFlight(photos.photos);
  // A straight flight has a hull, but one that is as thin as its errors.
  BoundingBox bounds;
  for (const Eigen::Vector2d& corner : hull)
    bounds.extend(Eigen::Vector3d(corner.x(), corner.y(), 0));
  constexpr double kMinRoundness = 0.05;
  if (hull.size() < 3 || SignedArea(hull) < kMinRoundness * bounds.diagonal().squaredNorm())
    return {};
  std::vector<WeightedPoint> inside;
  for (const SupportPoint& point : photos.points) {
    if (IsInside(hull, point.position.head<2>())) inside.push_back({point.position, 1});
  }
  const double wanted = kMinPartInside * static_cast<double>(photos.points.size());
  return inside.size() >= kMinPoints && static_cast<double>(inside.size()) >= wanted
             ? inside
             : std::vector<WeightedPoint>();
}

// Those that stand out of the ground; all of them when hardly any does.
std::vector<WeightedPoint> PointsOfObject(const std::vector<WeightedPoint>& inside, double ground) {
  constexpr double kGroundThickness = 0.06;  // part of the height
  constexpr double kMinPartStanding = 0.05;
  // A bump of the ground is no object: an object's height is a good part of its surroundings'
  // width.
  constexpr double kMinSlenderness = 0.04;
  const BoundingBox bounds = PercentileBounds(inside);
  const double height = bounds.max().z() - ground;
  if (height < kMinSlenderness * bounds.sizes().head<2>().maxCoeff()) return inside;
  std::vector<WeightedPoint> standing;
  for (const WeightedPoint& point : inside) {
    if (point.position.z() > ground + kGroundThickness * height) standing.push_back(point);
  }
  const double wanted = kMinPartStanding * static_cast<double>(inside.size());
  return static_cast<double>(standing.size()) >= wanted && standing.size() >= kMinPoints ? standing
                                                                                         : inside;
}

// Each point with the number of photos that have it in the middle half of the picture; points that
// no photo has there count a little, so that some remain.
std::vector<WeightedPoint> PointsNearOpticalAxes(const PhotoSet& photos) {
  constexpr double kWeightAtBorder = 0.05;
  std::vector<WeightedPoint> points;
  for (const SupportPoint& point : photos.points) {
    double weight = kWeightAtBorder;
    for (const int index : point.photo_indices) {
      const PosedPhoto& photo = photos.photos[static_cast<std::size_t>(index)];
      const Eigen::Vector3d in_cam = photo.cam_from_world * point.position;
      if (in_cam.z() <= 0) continue;
      const Eigen::Vector2d offset =
          photo.camera.Project(in_cam) - Eigen::Vector2d(photo.camera.cx, photo.camera.cy);
      if (std::abs(offset.x()) < 0.25 * photo.camera.width &&
          std::abs(offset.y()) < 0.25 * photo.camera.height) {
        weight += 1;
      }
    }
    points.push_back({point.position, weight});
  }
  return points;
}

BoundingBox FindBounds(const PhotoSet& photos, const WorldFrame& frame) {
  if (frame.is_metric_enu) {
    const std::vector<WeightedPoint> inside = PointsInsideFlight(photos);
    if (!inside.empty()) {
      const double ground = Percentile(inside, 2, kGroundPercentile);
      BoundingBox box = PercentileBounds(PointsOfObject(inside, ground));
      box.min().z() = std::min(ground, box.min().z());
      return box;
    }
  }
  return PercentileBounds(PointsNearOpticalAxes(photos));
}

}  // namespace

std::string RegionOptions::Check() const {
  if (!(margin_ratio >= 0 && margin_ratio <= 1)) {
    return "RegionOfInterest.margin_ratio must be in [0, 1]";
  }
  return "";
}

void BindOptions(OptionSet& set, RegionOptions* options) {
  const std::string section = "RegionOfInterest";
  set.Add(section, "box", &options->box,
          "x_min,y_min,z_min,x_max,y_max,z_max in the world, metres; empty: what the first photos "
          "look at");
  set.Add(section, "polygon_path", &options->polygon_path,
          "GeoJSON file with the polygon that has to be covered (longitude, latitude; without a "
          "place on Earth local metres)");
  set.Add(section, "margin_ratio", &options->margin_ratio,
          "widens the automatic region on each side, part of its width, 0 to 1");
}

BoundingBox ParseBox(const std::string& text) {
  std::vector<double> numbers;
  const char* place = text.data();
  const char* const end = place + text.size();
  const auto skip_spaces = [&] {
    while (place != end && *place == ' ') ++place;
  };
  bool is_valid = true;
  while (is_valid && numbers.size() < 6) {
    skip_spaces();
    double number = 0;
    const auto [next, error] = std::from_chars(place, end, number);
    is_valid = error == std::errc() && std::isfinite(number);
    place = next;
    skip_spaces();
    numbers.push_back(number);
    if (numbers.size() < 6) is_valid = is_valid && place != end && *place++ == ',';
  }
  if (is_valid && place == end) {
    const BoundingBox box(Eigen::Vector3d(numbers[0], numbers[1], numbers[2]),
                          Eigen::Vector3d(numbers[3], numbers[4], numbers[5]));
    if ((box.sizes().array() > 0).all()) return box;
  }
  throw UsageError(
      "RegionOfInterest.box must be x_min,y_min,z_min,x_max,y_max,z_max with each "
      "minimum below its maximum, not \"" +
      text + "\"");
}

std::string FormatBox(const BoundingBox& box) {
  std::string text;
  for (const Eigen::Vector3d& corner : {box.min(), box.max()}) {
    for (int axis = 0; axis < 3; ++axis) {
      char digits[32];
      const auto result = std::to_chars(std::begin(digits), std::end(digits), corner[axis]);
      text += (text.empty() ? "" : ",") + std::string(digits, result.ptr);
    }
  }
  return text;
}

namespace {

BoundingBox AutomaticBox(const PhotoSet& photos, const WorldFrame& frame,
                         const RegionOptions& options) {
  if (photos.points.size() < kMinPoints) {
    throw Error("the sparse model has only " + std::to_string(photos.points.size()) +
                " points, too few to find the region of interest; give --RegionOfInterest.box");
  }
  BoundingBox box = FindBounds(photos, frame);
  const double margin = options.margin_ratio * std::max(box.sizes().x(), box.sizes().y());
  box.min().array() -= margin;
  box.max().array() += margin;
  // Spires and chimneys have few points; above them is only air.
  constexpr double kTopMargin = 0.1;  // part of the height
  if (frame.is_metric_enu) box.max().z() += kTopMargin * box.sizes().z();
  return box;
}

// From the ground to the top of the points above the polygon, widened as the automatic box is.
void SetHeights(const PhotoSet& photos, const RegionOptions& options, RegionOfInterest* region) {
  constexpr double kTopMargin = 0.1;
  const double infinity = std::numeric_limits<double>::infinity();
  region->box.min().z() = -infinity;
  region->box.max().z() = infinity;
  std::vector<WeightedPoint> inside;
  for (const SupportPoint& point : photos.points) {
    if (region->Contains(point.position)) inside.push_back({point.position, 1});
  }
  if (inside.size() < kMinPoints) {
    throw Error(options.polygon_path.string() + ": only " + std::to_string(inside.size()) +
                " sparse points lie in the polygon, too few to find its height; check its "
                "coordinates, or give --RegionOfInterest.box too");
  }
  const BoundingBox bounds = PercentileBounds(inside);
  const double margin = options.margin_ratio * region->box.sizes().head<2>().maxCoeff();
  region->box.min().z() = bounds.min().z() - margin;
  region->box.max().z() = bounds.max().z() + margin + kTopMargin * bounds.sizes().z();
}

RegionOfInterest RegionOfPolygon(const PhotoSet& photos, const WorldFrame& frame,
                                 const RegionOptions& options) {
  RegionOfInterest region;
  region.rings = ReadPolygon(options.polygon_path, frame);
  for (const PolygonRing& ring : region.rings) {
    for (const Eigen::Vector2d& corner : ring)
      region.box.extend(Eigen::Vector3d(corner.x(), corner.y(), 0));
  }
  if (options.box.empty()) {
    SetHeights(photos, options, &region);
    return region;
  }
  const BoundingBox box = ParseBox(options.box);
  region.box.min().z() = box.min().z();
  region.box.max().z() = box.max().z();
  region.box = region.box.intersection(box);
  if (region.box.isEmpty()) {
    throw Error(options.polygon_path.string() + ": the polygon lies outside RegionOfInterest.box");
  }
  return region;
}

}  // namespace

RegionOfInterest DefaultRegion(const PhotoSet& photos, const WorldFrame& frame,
                               const RegionOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!options.polygon_path.empty()) return RegionOfPolygon(photos, frame, options);
  if (!options.box.empty()) return {ParseBox(options.box)};
  return {AutomaticBox(photos, frame, options)};
}

}  // namespace colmap_ext
