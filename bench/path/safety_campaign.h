// Plans through random sites and looks at every centimetre of what was accepted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/path/path_planner.h"
#include "random_site.h"

namespace colmap_ext {

struct SafetyFindings {
  int sites = 0;
  int flown_views = 0;
  int dropped_views = 0;
  int unnamed_drops = 0;        // views that are neither flown nor dropped with a reason
  int refused_starts = 0;       // planning said that the start is not safe
  int accepted_bad_starts = 0;  // it should have, and did not
  int sites_without_way = 0;    // every view was dropped, and it said so
  double length_m = 0;
  long long samples = 0;  // every centimetre of the line, and a place beside it
  // Least of: distance to the observed surface less the safe distance, metres.
  double least_spare_m = 1e9;
  long long too_near = 0;                // samples nearer than the safe distance
  long long unknown = 0;                 // samples in space that nothing is known about
  long long outside = 0;                 // samples beyond the fence or in the no-fly zone
  double overstated_clearance_m = -1e9;  // most that min_clearance_m is above what was sampled
  // From what was not reconstructed nothing can protect: sites where a path came within 10 cm of
  // anything.
  int near_unseen = 0;

  void Add(const SafetyFindings& other);
  // What breaks a promise; empty when nothing does.
  std::string Complaint() const;
};

// Options of the site with this seed: safe distance 1 … 3 m, position error 0 … 0.5 m, some with a
// fence and a no-fly zone.
PathOptions OptionsForSite(std::uint64_t seed);

SafetyFindings ExamineSite(std::uint64_t seed);

// Sites first_seed … first_seed + count - 1, in parallel.
SafetyFindings RunSafetyCampaign(std::uint64_t first_seed, int count);

}  // namespace colmap_ext
