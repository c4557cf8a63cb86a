// The mapper: photos with verified matches to poses and points.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct MappingPaths {
  std::filesystem::path database;
  std::filesystem::path images;
  std::filesystem::path work;  // for temporary models
  std::filesystem::path log;
};

// The largest model that the mapper makes from the database; empty (no images) when the matches
// give none. Focal lengths and distortion stay as the database has them unless `refine_intrinsics`.
Reconstruction MapFromScratch(const MappingPaths& paths, bool refine_intrinsics,
                              ColmapProgram* colmap, const JobControl& job);

// All models that the mapper makes from the database, in its order.
std::vector<Reconstruction> MapAll(const MappingPaths& paths, ColmapProgram* colmap,
                                   const JobControl& job);

// Registers the other photos of the database into `model` and triangulates; old poses and
// intrinsics stay as they are. The result is in the frame of `model`.
Reconstruction ContinueModel(const MappingPaths& paths, const Reconstruction& model,
                             ColmapProgram* colmap, const JobControl& job);

}  // namespace colmap_ext
