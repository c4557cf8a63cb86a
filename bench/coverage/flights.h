// The flights that the benchmark judges: one scene, photographed badly, middling and well.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

// Views around a scene whose model has these bounds, ids from 0:
//   "poor"      16 on the rectangle of a first flight, above the model;
//   "middling"  40 there;
//   "good"      those 40, and 28 each on two lower rectangles that look less far down.
// `indoor`: distances for a room and not for a building. Throws UsageError for another quality.
std::vector<PlannedView> FlightOf(const std::string& quality, const BoundingBox& model,
                                  bool indoor);

// All qualities, from bad to good.
const std::vector<std::string>& FlightQualities();

}  // namespace colmap_ext
