// Photos of a simulated scene with truth, rendered and mapped once and kept in a folder.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/scene/photo.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct SurveyOptions {
  std::string scene = "church";       // church, boxes or gate
  int num_photos = 81;                // on three rings, >= 6
  double texel_scale = 1;             // of the scene's textures
  bool sfm_poses = true;              // poses of `colmap mapper`; else the true ones
  std::filesystem::path cache;        // folder of everything that is made once
  std::filesystem::path colmap_path;  // empty: on the PATH
};

// What a view truly sees, one entry a pixel.
struct ViewTruth {
  cv::Mat1f depth;  // z at pixel centres; 0: sky
  cv::Mat1b model;  // not 0: the pixel's ray hits the model, not ground, floor or wall
};

struct Survey {
  PhotoSet photos;               // in the truth's frame
  std::vector<ViewTruth> truth;  // one a photo
};

// Renders the photos, and maps them with the real `colmap`, unless the cache has them. With SfM
// poses the model is brought to the truth's frame by a similarity of the camera centres, for depths
// to be compared. With true poses the points of the SfM tracks are triangulated anew from these.
Survey MakeSurvey(const SurveyOptions& options, const JobControl& job);

}  // namespace colmap_ext
