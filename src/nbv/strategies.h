// The strategies behind PlanNextViews. Each fills views (without ids), shared_features,
// reachable_uncovered, and what it knows of plane and tour.
#pragma once

#include <vector>

#include "nbv/search_context.h"

namespace colmap_ext {

void RunPlaneSweep(const SearchContext& context, const std::vector<Anchor>& anchors,
                   const JobControl& job, ViewPlanResult* result);

void RunSubmodular(const SearchContext& context, const std::vector<Anchor>& anchors,
                   const JobControl& job, ViewPlanResult* result);

// "random", "next_farthest_point" and "hemisphere".
void RunBaseline(const SearchContext& context, const JobControl& job, ViewPlanResult* result);

// "smith2018".
void RunSmith2018(const SearchContext& context, const JobControl& job, ViewPlanResult* result);

// Where the tour starts.
inline Eigen::Vector3d StartOf(const ViewPlanInput& input) {
  return input.start ? *input.start : CameraCenter(input.existing.back().cam_from_world);
}

}  // namespace colmap_ext
