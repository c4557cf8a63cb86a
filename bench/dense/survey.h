// What the benchmark reconstructs: a simulated first flight around the church, made once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct BenchSurvey {
  std::filesystem::path images_low, images_full;
  std::filesystem::path sfm_sparse;   // poses by structure from motion of the small photos
  std::filesystem::path true_sparse;  // the same points and tracks, true poses
  std::filesystem::path true_poses;
  TriangleMesh truth;
};

// `active_capture` of one iteration below `work_path`, unless it is there, and the model with true
// poses.
BenchSurvey MakeSurvey(const std::filesystem::path& work_path, int num_views,
                       const JobControl& job);

// superpixel_stereo and surface_reconstructor on a sparse model: the fast model.
struct FastModel {
  std::filesystem::path mesh;
  std::filesystem::path dense;  // its dense workspace
  double cpu_s = 0;
};
FastModel MakeFastModel(const BenchSurvey& survey, const std::filesystem::path& sparse,
                        const std::filesystem::path& output, const JobControl& job);

}  // namespace colmap_ext
