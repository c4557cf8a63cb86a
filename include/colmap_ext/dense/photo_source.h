// Photos of a sparse model, read one at a time, at the size that the files have.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// Immutable; Load may be called from many threads. The files may be of another size than the
// model's cameras (full-resolution photos, poses from small ones): intrinsics are scaled, each axis
// by its own ratio, for ratios that agree within 5 %.
class PhotoSource {
 public:
  // Reads the sizes of the photos of `model` in `image_path`. `max_width_px`: wider ones are scaled
  // down; 0: none. Throws Error naming the photo that is missing, no picture, or of another shape
  // than its camera.
  PhotoSource(const Reconstruction& model, const std::filesystem::path& image_path,
              int max_width_px);

  // Poses, ideal cameras of the pictures that Load gives, and points; sorted by name, no pixels.
  const PhotoSet& photo_set() const { return photo_set_; }
  const std::filesystem::path& image_path() const { return image_path_; }

  // The picture, undistorted, as its camera in photo_set() sees it: CV_8UC3.
  cv::Mat Load(std::size_t photo) const;

  // The model with photo_set()'s cameras, one a photo, and keypoints to match: what belongs to the
  // pictures that Load gives.
  Reconstruction PinholeModel() const;

 private:
  Eigen::Vector2d ScaleOf(std::size_t photo) const;  // pixels of Load over pixels of the model

  Reconstruction model_;
  std::filesystem::path image_path_;
  PhotoSet photo_set_;
};

}  // namespace colmap_ext
