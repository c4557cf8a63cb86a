#include "colmap_ext/mission/flight_patterns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include "colmap_ext/util/error.h"
#include "mission/pattern_names.h"

namespace colmap_ext {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kMostViews = 10000;

double PitchOf(const FlightPatternOptions& options, double own_deg) {
  return DegToRad(options.pitch_deg == 999 ? own_deg : options.pitch_deg);
}

// Size of what a photo shows at the pattern's distance, metres: across and along its height.
Eigen::Vector2d Footprint(const FlightPatternOptions& options) {
  const double across = 2 * options.distance_m * std::tan(DegToRad(options.horizontal_fov_deg) / 2);
  return {across, across * options.image_height_px / options.image_width_px};
}

int CountFor(double length_m, double spacing_m) {
  const double count = std::ceil(length_m / spacing_m - 1e-9);
  if (!(count <= kMostViews)) {
    throw Error(
        "flight pattern: the overlaps ask for more than 10000 photos; lower them, or set "
        "--Pattern.num_views");
  }
  return std::max(1, static_cast<int>(count));
}

// Views in the site's own axes, about its centre; turned into the world at the end.
class PatternMaker {
 public:
  PatternMaker(const PatternSite& site, const FlightPatternOptions& options)
      : site_(site), options_(options) {}

  std::vector<PlannedView> Make(Pattern pattern) {
    switch (pattern) {
      case Pattern::kGridDownward:
        MakeGrid(1);
        break;
      case Pattern::kGridMultiAngle:
        MakeGrid(options_.num_angles);
        break;
      case Pattern::kCircles:
        MakeCircles();
        break;
      case Pattern::kRectangleDense:
        MakeRectangles(options_.num_levels == 0 ? 3 : options_.num_levels, 0);
        break;
      case Pattern::kRectangleSparse:
        MakeRectangles(1, 0);
        break;
      case Pattern::kInitialRectangle:
        MakeRectangles(1, 64);
        break;
    }
    return TurnedIntoWorld();
  }

 private:
  void Add(const Eigen::Vector2d& place, double z, double yaw_rad, double pitch_rad) {
    PlannedView view;
    view.id = static_cast<int>(views_.size());
    view.position << place, z;
    view.direction = {NormalizeAngle(yaw_rad), pitch_rad};
    views_.push_back(view);
  }

  // Lines along the longer side; how many places each has.
  std::vector<int> PlacesOfLines(double length, double width) const {
    if (options_.num_views == 0) {
      const Eigen::Vector2d print = Footprint(options_);
      // A photo's width lies across the line.
      const int lines = 1 + CountFor(width, print.x() * (1 - options_.side_overlap));
      const int places = 1 + CountFor(length, print.y() * (1 - options_.forward_overlap));
      return std::vector<int>(static_cast<std::size_t>(lines), places);
    }
    const int total = options_.num_views / AnglesAPlace();
    // So many lines that the spacing along and across is about the same.
    const int lines =
        std::clamp(static_cast<int>(std::lround(std::sqrt(total * width / length))), 1, total);
    std::vector<int> places(static_cast<std::size_t>(lines), total / lines);
    for (int i = 0; i < total % lines; ++i) ++places[static_cast<std::size_t>(i)];
    return places;
  }

  int AnglesAPlace() const {
    return FindPattern(options_.name) == Pattern::kGridMultiAngle ? options_.num_angles : 1;
  }

  void MakeGrid(int angles) {
    if (options_.num_views % angles != 0) {
      throw UsageError(
          "Pattern.num_views must be a multiple of Pattern.num_angles for "
          "grid-multi-angle");
    }
    const bool is_long_in_x = site_.half_extent.x() >= site_.half_extent.y();
    const double half_length = site_.half_extent.maxCoeff();
    const double half_width = site_.half_extent.minCoeff();
    const std::vector<int> lines = PlacesOfLines(2 * half_length, 2 * half_width);
    const double z = site_.max_z_m + options_.distance_m;
    const auto along_line = [](std::size_t i, std::size_t count, double half) {
      return count == 1
                 ? 0.0
                 : -half + 2 * half * static_cast<double>(i) / static_cast<double>(count - 1);
    };
    for (std::size_t line = 0; line < lines.size(); ++line) {
      const double across = along_line(line, lines.size(), half_width);
      const auto places = static_cast<std::size_t>(lines[line]);
      for (std::size_t k = 0; k < places; ++k) {
        const std::size_t i = line % 2 == 0 ? k : places - 1 - k;  // back and forth
        const double along = along_line(i, places, half_length);
        Eigen::Vector2d place(along, across);
        if (!is_long_in_x) place = {-across, along};
        if (options_.num_views == 0 && !IsNearOutline(place)) continue;
        AddDirections(place, z, is_long_in_x ? kPi / 2 : 0, angles);
      }
    }
  }

  void AddDirections(const Eigen::Vector2d& place, double z, double heading_rad, int angles) {
    const double oblique_rad = PitchOf(options_, -45);
    Add(place, z, heading_rad, angles == 1 ? PitchOf(options_, -90) : -kPi / 2);
    for (int i = 0; i + 1 < angles; ++i) {
      Add(place, z, heading_rad + 2 * kPi * i / (angles - 1), oblique_rad);
    }
  }

  // Within half a spacing of the polygon, when the site is one.
  bool IsNearOutline(const Eigen::Vector2d& place) const {
    if (site_.outline.empty()) return true;
    FlightZone zone;
    zone.rings = {site_.outline};
    const Eigen::Vector2d world = ToWorld(place);
    const Eigen::Vector2d print = Footprint(options_);
    return zone.Depth({world.x(), world.y(), 0}) >= -print.x() * (1 - options_.side_overlap) / 2;
  }

  void MakeCircles() {
    const int circles = options_.num_levels == 0 ? 2 : options_.num_levels;
    const double radius = site_.half_extent.norm() + options_.distance_m;
    const double look_at = (site_.min_z_m + site_.max_z_m) / 2;
    int total = options_.num_views;
    if (total == 0) {
      const double spacing = Footprint(options_).x() * (1 - options_.forward_overlap);
      total = circles * CountFor(2 * kPi * radius, spacing);
    }
    for (int circle = 0; circle < circles; ++circle) {
      const double pitch = std::max(DegToRad(-85), PitchOf(options_, -30) - DegToRad(20) * circle);
      double z = look_at - radius * std::tan(pitch);
      z = std::max(z, site_.max_z_m + options_.height_above_top_m);
      // Where the height is not the one of the pitch, it still looks at the middle.
      const double real_pitch = std::atan2(look_at - z, radius);
      const int count = total / circles + (circle < total % circles ? 1 : 0);
      for (int i = 0; i < count; ++i) {
        // From the south, counter-clockwise.
        const double angle = -kPi / 2 + 2 * kPi * i / count;
        const Eigen::Vector2d place(radius * std::cos(angle), radius * std::sin(angle));
        Add(place, z, std::atan2(-place.x(), -place.y()), real_pitch);
      }
    }
  }

  void MakeRectangles(int levels, int own_count) {
    RegionOfInterest region;
    region.box =
        BoundingBox(Eigen::Vector3d(-site_.half_extent.x(), -site_.half_extent.y(), site_.min_z_m),
                    Eigen::Vector3d(site_.half_extent.x(), site_.half_extent.y(), site_.max_z_m));
    const Eigen::Vector2d print = Footprint(options_);
    int total = options_.num_views != 0 ? options_.num_views : own_count;
    if (total == 0) {
      const double perimeter = 4 * (site_.half_extent.sum() + 2 * options_.distance_m);
      total = levels * std::max(4, CountFor(perimeter, print.x() * (1 - options_.forward_overlap)));
    }
    if (total < 4 * levels) throw UsageError("Pattern.num_views must be at least 4 a level");
    double below_m = -std::numeric_limits<double>::infinity();
    for (int level = 0; level < levels; ++level) {
      InitialFlightOptions flight;
      flight.num_views = total / levels + (level < total % levels ? 1 : 0);
      flight.offset_m = options_.distance_m;
      flight.height_above_top_m = options_.height_above_top_m;
      const double first_deg = RadToDeg(PitchOf(options_, levels > 1 ? -15 : -30));
      flight.pitch_deg = std::max(-85.0, first_deg - 15 * level);
      flight.height_m = std::max(InitialFlightHeight(region, flight),
                                 below_m + print.y() * (1 - options_.side_overlap));
      below_m = flight.height_m;
      if (flight.height_m == 0) flight.height_m = 1e-9;  // 0 would mean "choose"
      for (const PlannedView& view : InitialRectangle(region, flight)) {
        Add(view.position.head<2>(), view.position.z(), view.direction.yaw_rad,
            view.direction.pitch_rad);
      }
    }
  }

  Eigen::Vector2d ToWorld(const Eigen::Vector2d& place) const {
    const double c = std::cos(site_.turn_rad), s = std::sin(site_.turn_rad);
    return site_.center +
           Eigen::Vector2d(c * place.x() - s * place.y(), s * place.x() + c * place.y());
  }

  std::vector<PlannedView> TurnedIntoWorld() {
    for (PlannedView& view : views_) {
      const Eigen::Vector2d place = ToWorld(view.position.head<2>());
      view.position.head<2>() = place;
      view.direction.yaw_rad = NormalizeAngle(view.direction.yaw_rad - site_.turn_rad);
    }
    return std::move(views_);
  }

  const PatternSite& site_;
  const FlightPatternOptions& options_;
  std::vector<PlannedView> views_;
};

}  // namespace

std::optional<Pattern> FindPattern(const std::string& name) {
  std::string plain = name;
  for (char& c : plain) c = c == '_' ? '-' : static_cast<char>(std::tolower(c));
  const std::array<std::pair<const char*, Pattern>, 6> patterns = {
      {{"grid-downward", Pattern::kGridDownward},
       {"grid-multi-angle", Pattern::kGridMultiAngle},
       {"2-circles", Pattern::kCircles},
       {"rectangle-sparse", Pattern::kRectangleSparse},
       {"rectangle-dense", Pattern::kRectangleDense},
       {"initial-rectangle", Pattern::kInitialRectangle}}};
  for (const auto& [known, pattern] : patterns) {
    if (plain == known) return pattern;
  }
  return std::nullopt;
}

PatternSite SiteOfBox(const BoundingBox& box) {
  PatternSite site;
  if (box.isEmpty()) return site;
  site.center = box.center().head<2>();
  site.half_extent = box.sizes().head<2>() / 2;
  site.min_z_m = box.min().z();
  site.max_z_m = box.max().z();
  return site;
}

PatternSite SiteOfZone(const FlightZone& zone, double min_z_m, double max_z_m) {
  if (zone.rings.empty() || zone.rings[0].size() < 3) {
    throw Error("flight pattern: the polygon has no outline");
  }
  PatternSite best;
  double best_area = std::numeric_limits<double>::infinity();
  const std::vector<Eigen::Vector2d>& ring = zone.rings[0];
  // A smallest box has a side along an edge of the convex hull, which joins two corners.
  for (std::size_t i = 0; i < ring.size(); ++i) {
    for (std::size_t j = i + 1; j < ring.size(); ++j) {
      const double turn = std::atan2(ring[j].y() - ring[i].y(), ring[j].x() - ring[i].x());
      const Eigen::Rotation2Dd to_own(-turn);
      Eigen::AlignedBox2d box;
      for (const Eigen::Vector2d& corner : ring) box.extend(to_own * corner);
      if (!(box.volume() < best_area - 1e-9)) continue;
      best_area = box.volume();
      best.center = to_own.inverse() * box.center();
      best.half_extent = box.sizes() / 2;
      best.turn_rad = turn;
    }
  }
  best.min_z_m = std::isfinite(zone.min_z_m) ? zone.min_z_m : min_z_m;
  best.max_z_m = std::isfinite(zone.max_z_m) ? zone.max_z_m : max_z_m;
  best.outline = ring;
  return best;
}

std::vector<PlannedView> MakeFlightPattern(const PatternSite& site,
                                           const FlightPatternOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!site.center.allFinite() || !site.half_extent.allFinite() ||
      !(site.half_extent.minCoeff() > 0) || !(site.max_z_m >= site.min_z_m) ||
      !std::isfinite(site.max_z_m) || !std::isfinite(site.min_z_m)) {
    throw Error("flight pattern: the site is empty: give its box, polygon or model");
  }
  return PatternMaker(site, options).Make(*FindPattern(options.name));
}

}  // namespace colmap_ext
