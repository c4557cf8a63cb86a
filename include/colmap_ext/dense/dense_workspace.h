// COLMAP's dense workspace: what image_undistorter makes, and maps to go with it.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/dense/photo_source.h"
#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/job_rank.h"

namespace colmap_ext {

struct DenseWorkspace {
  std::filesystem::path folder;
  std::filesystem::path images() const { return folder / "images"; }
  std::filesystem::path sparse() const { return folder / "sparse"; }
  std::filesystem::path stereo() const { return folder / "stereo"; }
  std::filesystem::path logs() const { return folder / "logs"; }
  // Of the photo `name`; `type` is "geometric" or "photometric".
  std::filesystem::path depth_map(const std::string& name,
                                  const std::string& type = "geometric") const;
  std::filesystem::path normal_map(const std::string& name) const;
  std::filesystem::path confidence_map(const std::string& name) const;
};

// images/ (undistorted, at the size of `photos`; those already there stay), sparse/ with one
// pinhole camera a photo, stereo/fusion.cfg and stereo/patch-match.cfg. Without `partners` the
// latter leaves the choice to COLMAP. Names keep their folders; photos are written in the format of
// their extension. Of several processes each writes its own photos, and the first one the rest.
void PrepareDenseWorkspace(const PhotoSource& photos, const std::vector<std::vector<int>>& partners,
                           const DenseWorkspace& workspace, const JobRank& rank,
                           const JobControl& job);

// CV_32FC1 … C16 with a channel of the map each.
cv::Mat MatOf(const DenseMap& map);
DenseMap MapOf(const cv::Mat& mat);

}  // namespace colmap_ext
