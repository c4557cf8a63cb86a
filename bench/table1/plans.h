// The flight plans that the paper's Table 1 compares, as lists of views.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/util/job_control.h"
#include "support/flown_site.h"

namespace colmap_ext {

struct FlownPlan {
  std::string name;
  std::vector<PlannedView> views;  // in the order of flight, ids from 0
};

// Straight lines from view to view, metres: the same measure for all plans.
double MetresOf(const std::vector<PlannedView>& views);

// A pattern of flight_planner around the object; `num_views` photos.
FlownPlan ManualPlan(const Site& site, const std::string& pattern, int num_views);

// The views of `plan` up to `metres` of flight; at least 3.
FlownPlan TrimmedTo(const FlownPlan& plan, double metres);

struct ActiveSession {
  std::string strategy = "submodular";
  int first_views = 64;   // of the first flight
  int max_photos = 108;   // the paper's count
  int flight_views = 12;  // of each later flight
  std::uint64_t seed = 1;
};

// Runs active_capture in `workspace` (kept, and gone on with) and returns the views that it flew,
// with the poses that they truly had.
FlownPlan ActivePlan(const Site& site, const ActiveSession& session,
                     const std::filesystem::path& workspace, const JobControl& job);

}  // namespace colmap_ext
