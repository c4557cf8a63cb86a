#include "colmap_ext/mission/patterns.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr double kQuarterTurn = 1.5707963267948966;

// The rectangle, counter-clockwise from its south-western corner.
struct Rectangle {
  Eigen::Vector2d corner;       // south-western
  std::array<double, 4> sides;  // lengths: south, east, north, west

  double Perimeter() const { return sides[0] + sides[1] + sides[2] + sides[3]; }
};

// Where an arc length falls: on which side, and how far along it.
struct PlaceOnRectangle {
  std::size_t side = 0;
  double along = 0;
};

PlaceOnRectangle Locate(const Rectangle& rectangle, double arc_length) {
  PlaceOnRectangle place;
  place.along = arc_length;
  while (place.side < 3 && place.along >= rectangle.sides[place.side]) {
    place.along -= rectangle.sides[place.side++];
  }
  return place;
}

Eigen::Vector2d PositionAt(const Rectangle& rectangle, const PlaceOnRectangle& place) {
  const double width = rectangle.sides[0];
  const double depth = rectangle.sides[1];
  switch (place.side) {
    case 0:
      return rectangle.corner + Eigen::Vector2d(place.along, 0);
    case 1:
      return rectangle.corner + Eigen::Vector2d(width, place.along);
    case 2:
      return rectangle.corner + Eigen::Vector2d(width - place.along, depth);
    default:
      return rectangle.corner + Eigen::Vector2d(0, depth - place.along);
  }
}

// The south side looks north (yaw 0), and each corner turns the heading to the left by 90 degrees.
// The turn is spread over `turn_length` before and after the corner.
double HeadingAt(const Rectangle& rectangle, const PlaceOnRectangle& place, double turn_length) {
  const double side_length = rectangle.sides[place.side];
  const double turn = std::min(turn_length, side_length / 2);
  const double side_heading = -kQuarterTurn * static_cast<double>(place.side);
  const double to_next_corner = side_length - place.along;
  double blend = 0;  // +0.5 at the corner behind, -0.5 at the corner ahead
  if (place.along < turn) blend = 0.5 * (1 - place.along / turn);
  if (to_next_corner < turn) blend = -0.5 * (1 - to_next_corner / turn);
  return NormalizeAngle(side_heading + blend * kQuarterTurn);
}

}  // namespace

std::string InitialFlightOptions::Check() const {
  if (num_views < 4 || num_views > 10000) return "InitialFlight.num_views must be in 4 … 10000";
  if (!(offset_m > 0) || !std::isfinite(offset_m)) {
    return "InitialFlight.offset_m must be > 0 (metres)";
  }
  if (!std::isfinite(height_m)) return "InitialFlight.height_m must be finite (metres)";
  if (!(height_above_top_m >= 0) || !std::isfinite(height_above_top_m)) {
    return "InitialFlight.height_above_top_m must be >= 0 (metres)";
  }
  if (!(std::abs(pitch_deg) < 90)) return "InitialFlight.pitch_deg must be in (-90, 90)";
  if (!(max_turn_deg > 0 && max_turn_deg <= 90)) {
    return "InitialFlight.max_turn_deg must be in (0, 90]";
  }
  return "";
}

void BindOptions(OptionSet& set, InitialFlightOptions* options) {
  const std::string s = "InitialFlight";
  set.Add(s, "num_views", &options->num_views, "photos of the first flight (4 … 10000)");
  set.Add(s, "offset_m", &options->offset_m, "distance from the sides of the region (metres, > 0)");
  set.Add(s, "height_m", &options->height_m,
          "height in the world (metres); 0: look at the middle of the region, from above its top");
  set.Add(s, "height_above_top_m", &options->height_above_top_m,
          "least height above the top of the region when chosen (metres, >= 0)");
  set.Add(s, "pitch_deg", &options->pitch_deg, "camera pitch, positive up (degrees, -90 … 90)");
  set.Add(s, "max_turn_deg", &options->max_turn_deg,
          "largest change of heading between neighbouring photos (degrees, 0 … 90)");
}

double InitialFlightHeight(const RegionOfInterest& region, const InitialFlightOptions& options) {
  if (options.height_m != 0) return options.height_m;
  const Eigen::Vector3d extent = region.box.sizes();
  const double mean_half_extent = (extent.x() + extent.y()) / 4;
  const double look_at = region.box.center().z() - std::tan(DegToRad(options.pitch_deg)) *
                                                       (options.offset_m + mean_half_extent);
  return std::max(look_at, region.box.max().z() + options.height_above_top_m);
}

std::vector<PlannedView> InitialRectangle(const RegionOfInterest& region,
                                          const InitialFlightOptions& options) {
  ThrowIfInvalid(options.Check());
  if (region.box.isEmpty() || !region.box.min().allFinite() || !region.box.max().allFinite()) {
    throw Error("the region of interest is empty: give its bounds to plan the first flight");
  }
  const Eigen::Vector3d extent = region.box.sizes();
  const double width = extent.x() + 2 * options.offset_m;
  const double depth = extent.y() + 2 * options.offset_m;
  const Rectangle rectangle{
      region.box.min().head<2>() - Eigen::Vector2d::Constant(options.offset_m),
      {width, depth, width, depth}};
  const double spacing = rectangle.Perimeter() / options.num_views;
  // Where a view at right angles would look past the box, that is within the offset of a corner,
  // the heading turns already; earlier, when that would be too quick.
  const double turn_length = std::max(options.offset_m, 90.0 / options.max_turn_deg * spacing / 2);
  const double height = InitialFlightHeight(region, options);

  std::vector<PlannedView> views(static_cast<std::size_t>(options.num_views));
  for (int i = 0; i < options.num_views; ++i) {
    const PlaceOnRectangle place = Locate(rectangle, spacing * i);
    PlannedView& view = views[static_cast<std::size_t>(i)];
    view.id = i;
    view.position << PositionAt(rectangle, place), height;
    view.direction.yaw_rad = HeadingAt(rectangle, place, turn_length);
    view.direction.pitch_rad = DegToRad(options.pitch_deg);
  }
  return views;
}

FlightPath PathInOrder(const std::vector<PlannedView>& views, double speed_m_s, double hover_s) {
  FlightPath path;
  for (const PlannedView& view : views) {
    if (!path.waypoints.empty()) {
      path.length_m += (view.position - path.waypoints.back().position).norm();
    }
    path.waypoints.push_back({view.position, view.direction, view.id});
  }
  path.duration_s = path.length_m / speed_m_s + hover_s * static_cast<double>(views.size());
  return path;
}

}  // namespace colmap_ext
