// Photos of a simulated scene with a sparse model, as SfM would give it, kept in a cache folder.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct SurveySpec {
  std::string scene = "church";  // one that MakeScene knows
  int photos = 81;               // >= 3
  int width = 640;               // px
  int height = 368;              // px
  double texel_scale = 1.0;      // of MakeScene
};

struct Survey {
  std::filesystem::path images;      // photos as JPEG, quality 95
  std::filesystem::path true_model;  // true poses and simulated points
  std::filesystem::path positions;   // of the cameras, exact (for georegistration)
};

// Cameras on rings around a scene's model that look at it, `count` in all: the more there are, the
// more rings, so that a photo's surroundings stay alike.
std::vector<Rigid3d> RingPoses(const Eigen::Vector3d& model_center,
                               const Eigen::Vector3d& model_size, int count);

// Renders what `folder` does not have yet. Points: image corners on the surface, seen with 0.4 px
// of noise by some of the nearest photos and triangulated from there, about 600 observations a
// photo; one observation in a hundred is wrong.
Survey PrepareSurvey(const SurveySpec& spec, const std::filesystem::path& folder,
                     const JobControl& job);

// The model that COLMAP makes of the survey's photos (UpdateSparseModel, the camera's intrinsics
// given, georegistered to the true positions), kept in the same folder. Returns its path.
std::filesystem::path PrepareRealSfm(const Survey& survey, const std::filesystem::path& folder,
                                     const JobControl& job);

}  // namespace colmap_ext
