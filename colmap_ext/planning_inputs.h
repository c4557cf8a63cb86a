// What view and path planning start from.
#pragma once

#include <filesystem>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/job_control.h"

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

// The surface of `mesh_path` for path planning: with its signal, where the file has it and the
// options ask for confidence; else all of it is confident.
Surface ConfidentSurface(const PlanningInputs& inputs, const std::filesystem::path& mesh_path,
                         const PathOptions& options, const JobControl& job);

}  // namespace colmap_ext
