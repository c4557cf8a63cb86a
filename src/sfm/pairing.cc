#include "colmap_ext/sfm/pairing.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

PhotoPair Ordered(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

constexpr const char* kOverlap = "overlap";
constexpr const char* kRadius = "radius";

bool AxesAgree(const PhotoPlace& a, const PhotoPlace& b, double min_cosine) {
  if (!a.optical_axis || !b.optical_axis) return true;
  return a.optical_axis->dot(*b.optical_axis) >= min_cosine;
}

// Neighbours of photo `i` among those with a position: all within the radius up to max_neighbors,
// and never fewer than min_neighbors.
std::vector<int> NearestPhotos(const std::vector<PhotoPlace>& places, int i, double min_cosine,
                               const PairingOptions& options) {
  const PhotoPlace& place = places[static_cast<std::size_t>(i)];
  std::vector<std::pair<double, int>> by_distance;
  for (int j = 0; j < static_cast<int>(places.size()); ++j) {
    const PhotoPlace& other = places[static_cast<std::size_t>(j)];
    if (j == i || !other.position_m || !AxesAgree(place, other, min_cosine)) continue;
    by_distance.emplace_back((*other.position_m - *place.position_m).norm(), j);
  }
  const auto wanted = std::min(by_distance.size(), static_cast<std::size_t>(options.max_neighbors));
  std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(wanted),
                    by_distance.end());
  std::vector<int> neighbors;
  for (std::size_t k = 0; k < wanted; ++k) {
    const bool near = by_distance[k].first <= options.max_distance_m;
    if (near || k < static_cast<std::size_t>(options.min_neighbors)) {
      neighbors.push_back(by_distance[k].second);
    }
  }
  return neighbors;
}

// Partners of a photo without position, by its place in the name order.
std::vector<int> SequentialPhotos(int count, int i, const PairingOptions& options) {
  std::vector<int> partners;
  if (count <= options.exhaustive_limit) {
    for (int j = 0; j < count; ++j) {
      if (j != i) partners.push_back(j);
    }
    return partners;
  }
  std::set<int> offsets;
  for (int offset = 1; offset <= options.sequential_overlap; ++offset) offsets.insert(offset);
  for (int offset = 1; offset < count; offset *= 2) offsets.insert(offset);
  for (const int offset : offsets) {
    if (i - offset >= 0) partners.push_back(i - offset);
    if (i + offset < count) partners.push_back(i + offset);
  }
  return partners;
}

// 1 up to `full`, falling to 0 at `none`.
double Fade(double value, double full, double none) {
  return std::clamp((none - value) / (none - full), 0.0, 1.0);
}

// World to a camera without roll.
struct LevelFrame {
  explicit LevelFrame(const PhotoPlace& place) : center(*place.position_m), z(*place.optical_axis) {
    const Eigen::Vector3d level = z.cross(Eigen::Vector3d::UnitZ());
    x = level.norm() > 1e-6 ? Eigen::Vector3d(level.normalized()) : Eigen::Vector3d::UnitX();
    y = z.cross(x);
  }
  Eigen::Vector3d center, x, y, z;
};

std::vector<Eigen::Vector3d> SurfaceSamples(const PhotoPlace& place, double distance_m) {
  if (!place.seen_points.empty()) return place.seen_points;
  const LevelFrame frame(place);
  std::vector<Eigen::Vector3d> samples;
  for (const double u : {-0.75, -0.25, 0.25, 0.75}) {
    for (const double v : {-0.7, 0.0, 0.7}) {
      const Eigen::Vector3d ray =
          frame.z + u * place.half_width * frame.x + v * place.half_height * frame.y;
      samples.push_back(frame.center + distance_m * ray);
    }
  }
  return samples;
}

// Part of the samples of `a` that `b` shows, weighted by how alike both see them.
double PartShown(const PhotoPlace& a, double a_distance_m, const PhotoPlace& b) {
  const LevelFrame frame(b);
  const std::vector<Eigen::Vector3d> samples = SurfaceSamples(a, a_distance_m);
  double sum = 0;
  for (const Eigen::Vector3d& sample : samples) {
    const Eigen::Vector3d from_a = sample - *a.position_m, from_b = sample - frame.center;
    const double depth = from_b.dot(frame.z);
    if (!(depth > 0) || std::abs(from_b.dot(frame.x)) > b.half_width * depth ||
        std::abs(from_b.dot(frame.y)) > b.half_height * depth) {
      continue;
    }
    const double far = std::max(from_a.norm(), from_b.norm());
    const double near = std::min(from_a.norm(), from_b.norm());
    if (!(near > 0)) continue;
    const double cosine = from_a.dot(from_b) / (near * far);
    const double angle_deg = RadToDeg(std::acos(std::clamp(cosine, -1.0, 1.0)));
    sum += Fade(angle_deg, 25, 60) * Fade(far / near, 1.5, 3);
  }
  return sum / static_cast<double>(samples.size());
}

bool HasPose(const PhotoPlace& place) { return place.position_m && place.optical_axis; }

// The point that the axes pass nearest; empty where they are parallel.
std::optional<Eigen::Vector3d> CommonTarget(const std::vector<PhotoPlace>& places) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double count = 0;
  for (const PhotoPlace& place : places) {
    if (!HasPose(place)) continue;
    const Eigen::Vector3d& axis = *place.optical_axis;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * *place.position_m;
    ++count;
  }
  constexpr double kParallel = 0.01;  // mean square of the sine of the axes' angles
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal);
  if (count == 0 || solver.eigenvalues()[0] < kParallel * count) return std::nullopt;
  return normal.ldlt().solve(right);
}

// Median distance from a photo to the one nearest to it.
double TypicalSpacing(const std::vector<PhotoPlace>& places) {
  constexpr std::size_t kSampled = 200;
  const std::size_t step = places.size() / kSampled + 1;
  std::vector<double> spacings;
  for (std::size_t i = 0; i < places.size(); i += step) {
    if (!places[i].position_m) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < places.size(); ++j) {
      if (j == i || !places[j].position_m) continue;
      nearest = std::min(nearest, (*places[i].position_m - *places[j].position_m).norm());
    }
    if (std::isfinite(nearest)) spacings.push_back(nearest);
  }
  return spacings.empty() ? 0 : MiddleValue(spacings);
}

// Partners of photo `i` by expected overlap, best first.
std::vector<int> OverlappingPhotos(const std::vector<PhotoPlace>& places,
                                   const std::vector<double>& distances_m, int i,
                                   const PairingOptions& options) {
  const double min_cosine = std::cos(DegToRad(options.max_axis_angle_deg));
  const auto index = static_cast<std::size_t>(i);
  std::vector<std::pair<double, int>> by_overlap;
  for (std::size_t j = 0; j < places.size(); ++j) {
    if (j == index || !places[j].position_m) continue;
    if (!AxesAgree(places[index], places[j], min_cosine)) continue;
    // One whose heading is unknown may show as much as one can hope for.
    const double overlap =
        HasPose(places[j])
            ? ExpectedOverlap(places[index], distances_m[index], places[j], distances_m[j])
            : 1 / (1 + (*places[index].position_m - *places[j].position_m).norm() /
                           std::max(distances_m[index], 1e-9));
    if (overlap > 0) by_overlap.emplace_back(-overlap, static_cast<int>(j));
  }
  std::sort(by_overlap.begin(), by_overlap.end());
  const int limit =
      places[index].seen_points.empty() ? options.max_neighbors : options.min_neighbors;
  std::vector<int> partners;
  for (const auto& [negative_overlap, j] : by_overlap) {
    const auto count = static_cast<int>(partners.size());
    if (count == limit) break;
    if (-negative_overlap < options.min_overlap && count >= options.min_neighbors) break;
    partners.push_back(j);
  }
  return partners;
}

}  // namespace

double ExpectedOverlap(const PhotoPlace& a, double a_distance_m, const PhotoPlace& b,
                       double b_distance_m) {
  return 0.5 * (PartShown(a, a_distance_m, b) + PartShown(b, b_distance_m, a));
}

std::vector<double> GuessSceneDistances(const std::vector<PhotoPlace>& places) {
  constexpr double kSpacings = 4;
  const std::optional<Eigen::Vector3d> target = CommonTarget(places);
  const double spacing_m = TypicalSpacing(places);
  std::vector<double> distances;
  for (const PhotoPlace& place : places) {
    if (!HasPose(place)) {
      distances.push_back(0);
      continue;
    }
    std::vector<double> known;
    for (const Eigen::Vector3d& point : place.seen_points) {
      known.push_back((point - *place.position_m).dot(*place.optical_axis));
    }
    double distance = kSpacings * spacing_m;
    if (target) {
      distance = std::max((*target - *place.position_m).dot(*place.optical_axis), spacing_m);
    }
    distances.push_back(known.empty() ? distance : MiddleValue(known));
  }
  return distances;
}

std::string PairingOptions::Check() const {
  if (strategy != kOverlap && strategy != kRadius) {
    return "Pairing.strategy must be overlap or radius";
  }
  if (!(min_overlap > 0 && min_overlap < 1)) {
    return "Pairing.min_overlap must be above 0 and below 1";
  }
  if (!(max_distance_m > 0)) return "Pairing.max_distance_m must be above 0 m";
  if (min_neighbors < 1) return "Pairing.min_neighbors must be at least 1";
  if (max_neighbors < min_neighbors) {
    return "Pairing.max_neighbors must not be below Pairing.min_neighbors";
  }
  if (!(max_axis_angle_deg > 0 && max_axis_angle_deg <= 180)) {
    return "Pairing.max_axis_angle_deg must be above 0 and at most 180 degrees";
  }
  if (exhaustive_limit < 2) return "Pairing.exhaustive_limit must be at least 2";
  if (sequential_overlap < 1) return "Pairing.sequential_overlap must be at least 1";
  return "";
}

void BindOptions(OptionSet& set, PairingOptions* options) {
  set.Add("Pairing", "strategy", &options->strategy,
          "match photos by expected overlap of what they show, or by radius (the paper)");
  set.Add("Pairing", "min_overlap", &options->min_overlap,
          "overlap: part of a photo that the other has to show as well (0 < p < 1)");
  set.Add("Pairing", "max_distance_m", &options->max_distance_m,
          "radius: match photos nearer than this (m, > 0)");
  set.Add("Pairing", "min_neighbors", &options->min_neighbors,
          "match every photo with at least so many best or nearest ones (>= 1)");
  set.Add("Pairing", "max_neighbors", &options->max_neighbors,
          "... and with at most so many (>= min_neighbors)");
  set.Add("Pairing", "max_axis_angle_deg", &options->max_axis_angle_deg,
          "skip pairs whose optical axes, when known, differ by more (deg, 0 < a <= 180)");
  set.Add("Pairing", "exhaustive_limit", &options->exhaustive_limit,
          "photos without position: match all pairs up to so many photos (>= 2)");
  set.Add("Pairing", "sequential_overlap", &options->sequential_overlap,
          "... and beyond it so many next ones in name order (>= 1)");
}

std::vector<PhotoPair> ChoosePairs(const std::vector<PhotoPlace>& places,
                                   const std::vector<bool>& is_new,
                                   const std::set<PhotoPair>& existing,
                                   const PairingOptions& options) {
  ThrowIfInvalid(options.Check());
  const int count = static_cast<int>(places.size());
  const double min_cosine = std::cos(DegToRad(options.max_axis_angle_deg));
  const bool by_overlap = options.strategy == kOverlap;
  const std::vector<double> distances_m =
      by_overlap ? GuessSceneDistances(places) : std::vector<double>(places.size(), 0);
  const auto partners_of = [&](int i) {
    const PhotoPlace& place = places[static_cast<std::size_t>(i)];
    if (!place.position_m) return SequentialPhotos(count, i, options);
    if (by_overlap && place.optical_axis) {
      return OverlappingPhotos(places, distances_m, i, options);
    }
    return NearestPhotos(places, i, min_cosine, options);
  };
  std::set<PhotoPair> pairs;
  for (int i = 0; i < count; ++i) {
    // An old photo whose place is known is asked for by the new ones.
    const bool asks = is_new[static_cast<std::size_t>(i)];
    if (!asks && places[static_cast<std::size_t>(i)].position_m) continue;
    for (const int j : partners_of(i)) {
      if (!asks && !is_new[static_cast<std::size_t>(j)]) continue;
      const PhotoPair pair = Ordered(i, j);
      if (existing.count(pair) == 0) pairs.insert(pair);
    }
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace colmap_ext
