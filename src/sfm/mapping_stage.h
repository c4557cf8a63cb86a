// The mapper: photos with verified matches to poses and points.
#pragma once

#include <filesystem>

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

// Registers more photos into `model` and triangulates, intrinsics locked. With `adjust_all` every
// pose is adjusted, else only the new ones. The result is in the frame of `model`.
Reconstruction ContinueModel(const MappingPaths& paths, const Reconstruction& model,
                             bool adjust_all, ColmapProgram* colmap, const JobControl& job);

}  // namespace colmap_ext
