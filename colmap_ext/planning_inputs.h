// What view and path planning start from.
#pragma once

#include <filesystem>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/world_frame.h"

namespace colmap_ext {

struct PlanningInputs {
  WorldFrame frame;
  TriangleMesh surface;
  PhotoSet photos;  // without pixels; at least one
};

// Reads the poses of a sparse model (cameras scaled to `max_width_px`; 0: as they are), the
// surface, and the frame.json beside the model. Throws Error when the world is not metric or there
// is no photo.
PlanningInputs ReadPlanningInputs(const std::filesystem::path& sparse_path,
                                  const std::filesystem::path& mesh_path, int max_width_px);

}  // namespace colmap_ext
