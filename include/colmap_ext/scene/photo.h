// A photo ready for the dense stages: undistorted, with its pose.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

struct PosedPhoto {
  ImageId image_id = 0;
  std::string name;
  PinholeCamera camera;
  Rigid3d cam_from_world;
  Camera lens;  // the model's camera, that `bgr` was undistorted from; width 0: unknown
  cv::Mat bgr;  // CV_8UC3, camera.width x camera.height; empty in stages that need no pixels
};

// A sparse point as the dense stages use it: tracks refer to positions in a vector of PosedPhoto.
struct SupportPoint {
  Eigen::Vector3d position;        // world
  double error_px = 0;             // mean reprojection error
  std::vector<int> photo_indices;  // sorted, each once
};

// The registered photos of a model (sorted by name) and its points.
struct PhotoSet {
  std::vector<PosedPhoto> photos;
  std::vector<SupportPoint> points;
};

// Makes the photos of `reconstruction`; those whose camera is not a pinhole get an ideal one. With
// `with_pixels` their pictures are read from `image_path` (LoadPixels). Throws Error when cameras,
// images and points do not belong together.
PhotoSet LoadPhotoSet(const Reconstruction& reconstruction, const std::string& image_path,
                      bool with_pixels);

// Reads the pictures of the photos (of LoadPhotoSet) with which[i] != 0 from `image_path`, in
// parallel, undistorts those whose lens is not a pinhole, and scales them to the size of
// photos[i].camera (area averaging). Throws Error naming the photo that is missing, cannot be
// decoded, or is not of its lens's size.
void LoadPixels(const Reconstruction& reconstruction, const std::string& image_path,
                const std::vector<std::uint8_t>& which, std::vector<PosedPhoto>* photos);

// Reads a picture as BGR without applying its EXIF orientation (as COLMAP does). Throws Error
// naming the file when it is missing, truncated or no picture.
cv::Mat ReadPhoto(const std::string& path);

// Writes a picture in the format of its extension, atomically. `jpeg_quality` (0 … 100) is of JPEG
// alone. Throws Error naming the file when its extension is no picture's.
void WritePhoto(const cv::Mat& bgr, const std::filesystem::path& path, int jpeg_quality = 95);

// For each photo the others that show the same points, best first, at most `max_partners`.
// `score(ray_a, ray_b)`: what one shared point is worth, from the vectors (world) from the centres
// of both photos to it; not positive: nothing. Called from several threads. Partners are ranked by
// the sum.
std::vector<std::vector<int>> RankPartners(
    const PhotoSet& photos,
    const std::function<double(const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b)>& score,
    int max_partners);

}  // namespace colmap_ext
