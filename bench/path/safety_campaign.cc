#include "safety_campaign.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kSampling_m = 0.01;
constexpr double kFar_m = 1e9;

bool IsIn(const FlightZone& zone, const Eigen::Vector3d& point) {
  // The campaign's zones are rectangles.
  const auto& ring = zone.rings[0];
  return point.x() >= ring[0].x() && point.x() <= ring[2].x() && point.y() >= ring[0].y() &&
         point.y() <= ring[2].y() && point.z() >= zone.min_z_m && point.z() <= zone.max_z_m;
}

class Examiner {
 public:
  Examiner(std::uint64_t seed, const RandomSite& site, const PathOptions& options)
      : random_(seed + 1000003), site_(site), options_(options) {
    top_m_ = -1e9;
    for (const Patch& patch : site.observed) top_m_ = std::max(top_m_, patch.box.max().z());
  }

  SafetyFindings Examine(const FlightPath& path) {
    CountViews(path);
    findings_.length_m = path.length_m;
    double least = kFar_m;
    for (std::size_t i = 0; i + 1 < path.waypoints.size(); ++i) {
      least = std::min(least,
                       ExamineSegment(path.waypoints[i].position, path.waypoints[i + 1].position));
    }
    if (least < kFar_m) {
      findings_.overstated_clearance_m = path.min_clearance_m - least;
    }
    return findings_;
  }

 private:
  void CountViews(const FlightPath& path) {
    for (const Waypoint& waypoint : path.waypoints) {
      findings_.flown_views += waypoint.view_id >= 0 ? 1 : 0;
    }
    findings_.dropped_views = static_cast<int>(path.dropped_view_ids.size());
    findings_.unnamed_drops =
        static_cast<int>(site_.views.size()) - findings_.flown_views - findings_.dropped_views;
    if (path.drop_reasons.size() != path.dropped_view_ids.size()) ++findings_.unnamed_drops;
    for (const std::string& reason : path.drop_reasons) {
      findings_.unnamed_drops += reason.empty() ? 1 : 0;
    }
    findings_.sites_without_way = findings_.flown_views == 0 ? 1 : 0;
  }

  // Where the vehicle may be when it should be at `on_line`.
  Eigen::Vector3d Astray(const Eigen::Vector3d& on_line) {
    std::normal_distribution<double> normal;
    const Eigen::Vector3d direction(normal(random_), normal(random_), normal(random_));
    return on_line + options_.position_error_m * direction.normalized();
  }

  // Returns the least distance of the places to the observed surface where that is near.
  double ExamineSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double reach_m = options_.safe_distance_m + options_.position_error_m + 1;
    Eigen::AlignedBox3d around(a);
    around.extend(b);
    const std::vector<Patch> near = PatchesNear(site_.observed, around, reach_m);
    const int steps = 1 + static_cast<int>((b - a).norm() / kSampling_m);
    double least = kFar_m;
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector3d on_line = a + (b - a) * k / steps;
      // The nearest that the vehicle can be to the surface when it should be there.
      const double of_line = DistanceToPatches(near, on_line, reach_m);
      const double distance = of_line - options_.position_error_m;
      // Further surface is not in `near`.
      if (of_line < reach_m - 1e-6) least = std::min(least, distance);
      findings_.least_spare_m =
          std::min(findings_.least_spare_m, distance - options_.safe_distance_m);
      findings_.too_near += distance < options_.safe_distance_m ? 1 : 0;
      const Eigen::Vector3d place = Astray(on_line);
      findings_.unknown += IsKnown(place) ? 0 : 1;
      findings_.outside += IsAllowed(place) ? 0 : 1;
      ++findings_.samples;
      for (const Eigen::AlignedBox3d& solid : site_.solids) {
        if (solid.squaredExteriorDistance(place) < 0.01) findings_.near_unseen = 1;
      }
    }
    return least;
  }

  bool IsKnown(const Eigen::Vector3d& place) {
    if (place.z() >= top_m_ + options_.safe_distance_m) return true;
    if (site_.flown.exteriorDistance(place) <= options_.flown_margin_m) return true;
    // The photo that knew the last place most likely knows this one.
    if (SightOf(site_.photos[last_photo_], site_.observed, place) == Sight::kThrough) return true;
    for (std::size_t i = 0; i < site_.photos.size(); ++i) {
      if (SightOf(site_.photos[i], site_.observed, place) == Sight::kThrough) {
        last_photo_ = i;
        return true;
      }
    }
    return WasVisited(place);
  }

  // Where the vehicle is or was there is room for it, but no more.
  bool WasVisited(const Eigen::Vector3d& place) const {
    const double room_m = 2 * options_.position_error_m + 1e-9;
    // It must be able to leave its place, off the line as it may be.
    if ((place - site_.start).norm() <= room_m + options_.position_error_m) return true;
    return std::any_of(site_.photos.begin(), site_.photos.end(), [&](const PosedPhoto& photo) {
      return (place - CameraCenter(photo.cam_from_world)).norm() <= room_m;
    });
  }

  bool IsAllowed(const Eigen::Vector3d& place) const {
    for (const FlightZone& zone : options_.limits.zones) {
      if (IsIn(zone, place) != (zone.kind == FlightZone::Kind::kInclusion)) return false;
    }
    return true;
  }

  std::mt19937_64 random_;
  const RandomSite& site_;
  const PathOptions& options_;
  SafetyFindings findings_;
  double top_m_ = 0;
  std::size_t last_photo_ = 0;
};

FlightZone Rectangle(FlightZone::Kind kind, double x0, double y0, double x1, double y1) {
  FlightZone zone;
  zone.kind = kind;
  zone.rings = {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}};
  return zone;
}

}  // namespace

void SafetyFindings::Add(const SafetyFindings& other) {
  sites += other.sites;
  flown_views += other.flown_views;
  dropped_views += other.dropped_views;
  unnamed_drops += other.unnamed_drops;
  refused_starts += other.refused_starts;
  accepted_bad_starts += other.accepted_bad_starts;
  sites_without_way += other.sites_without_way;
  length_m += other.length_m;
  samples += other.samples;
  least_spare_m = std::min(least_spare_m, other.least_spare_m);
  too_near += other.too_near;
  unknown += other.unknown;
  outside += other.outside;
  overstated_clearance_m = std::max(overstated_clearance_m, other.overstated_clearance_m);
  near_unseen += other.near_unseen;
}

std::string SafetyFindings::Complaint() const {
  if (too_near > 0) return std::to_string(too_near) + " places too near to observed surface";
  if (unknown > 0) return std::to_string(unknown) + " places in unknown space";
  if (outside > 0) return std::to_string(outside) + " places beyond the flight limits";
  if (unnamed_drops > 0) return std::to_string(unnamed_drops) + " views lost without a reason";
  if (accepted_bad_starts > 0) return "a start inside of an obstacle was accepted";
  if (overstated_clearance_m > 1e-4) return "the proved clearance is above the sampled one";
  return "";
}

PathOptions OptionsForSite(std::uint64_t seed) {
  std::mt19937_64 random(seed + 500009);
  std::uniform_real_distribution<double> between(0, 1);
  PathOptions options;
  options.safe_distance_m = 1 + 2 * between(random);
  options.position_error_m = between(random) < 0.2 ? 0 : 0.5 * between(random);
  options.flown_margin_m = 1 + 3 * between(random);
  options.detour_margin_m = 8;
  options.start_tolerance_m = 0;
  if (between(random) < 0.3) {
    options.limits.zones = {Rectangle(FlightZone::Kind::kInclusion, -28, -28, 28, 28),
                            Rectangle(FlightZone::Kind::kExclusion, -4, 2, 9, 12)};
  }
  return options;
}

SafetyFindings ExamineSite(std::uint64_t seed) {
  const RandomSite site = MakeRandomSite(seed);
  PathOptions options = OptionsForSite(seed);
  options.vouched_photos.emplace();
  for (std::size_t i = 0; i < site.num_first_photos; ++i) {
    options.vouched_photos->insert(site.photos[i].name);
  }
  SafetyFindings findings;
  try {
    const FlightPath path =
        PlanPath(site.start, site.views, ObservedSurface(site), site.photos, options, JobControl());
    findings = Examiner(seed, site, options).Examine(path);
    findings.accepted_bad_starts = site.start_kind == "inside" ? 1 : 0;
  } catch (const Error&) {
    findings.refused_starts = 1;
  }
  findings.sites = 1;
  return findings;
}

SafetyFindings RunSafetyCampaign(std::uint64_t first_seed, int count) {
  std::vector<SafetyFindings> each(static_cast<std::size_t>(count));
  ParallelFor(each.size(), [&](std::size_t i) { each[i] = ExamineSite(first_seed + i); });
  SafetyFindings all;
  for (const SafetyFindings& findings : each) all.Add(findings);
  return all;
}

}  // namespace colmap_ext
