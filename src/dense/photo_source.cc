#include "colmap_ext/dense/photo_source.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kMaxShapeDifference = 0.05;

void CheckShape(const PhotoMetadata& file, const Camera& camera, const std::string& path) {
  const double ratio_x = static_cast<double>(file.width) / camera.width;
  const double ratio_y = static_cast<double>(file.height) / camera.height;
  if (std::abs(ratio_x / ratio_y - 1) <= kMaxShapeDifference) return;
  throw Error(
      path + ": the photo has " + std::to_string(file.width) + " x " + std::to_string(file.height) +
      " pixels, another shape than its camera in the model, " + std::to_string(camera.width) +
      " x " + std::to_string(camera.height) + "; was it cropped?");
}

// Where each pixel of `ideal` lies in a picture that is `ratio` times the size of `camera`'s.
cv::Mat UndistortMap(const Camera& camera, const PinholeCamera& ideal,
                     const Eigen::Vector2d& ratio) {
  cv::Mat map(ideal.height, ideal.width, CV_32FC2);
  ParallelFor(ideal.height, [&](int y) {
    for (int x = 0; x < ideal.width; ++x) {
      const Eigen::Vector3d ray = ideal.Ray({x + 0.5, y + 0.5});
      const Eigen::Vector2d pixel = ImageFromNormalized(camera, ray.head<2>()).cwiseProduct(ratio);
      map.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel.x() - 0.5),
                                 static_cast<float>(pixel.y() - 0.5)};
    }
  });
  return map;
}

}  // namespace

PhotoSource::PhotoSource(const Reconstruction& model, const std::filesystem::path& image_path,
                         int max_width_px)
    : model_(model),
      image_path_(image_path),
      photo_set_(LoadPhotoSet(model, image_path.string(), false)) {
  for (PosedPhoto& photo : photo_set_.photos) {
    const std::filesystem::path path = image_path / photo.name;
    const PhotoMetadata file = ReadPhotoMetadata(path);
    CheckShape(file, model_.cameras.at(model_.images.at(photo.image_id).camera_id), path.string());
    int width = file.width;
    int height = file.height;
    if (max_width_px > 0 && width > max_width_px) {
      height = static_cast<int>(std::lround(static_cast<double>(height) * max_width_px / width));
      width = max_width_px;
    }
    photo.camera = ScaleTo(photo.camera, width, std::max(1, height));
  }
}

Eigen::Vector2d PhotoSource::ScaleOf(std::size_t photo) const {
  const PosedPhoto& posed = photo_set_.photos[photo];
  const Camera& camera = model_.cameras.at(model_.images.at(posed.image_id).camera_id);
  return {static_cast<double>(posed.camera.width) / camera.width,
          static_cast<double>(posed.camera.height) / camera.height};
}

cv::Mat PhotoSource::Load(std::size_t photo) const {
  const PosedPhoto& posed = photo_set_.photos[photo];
  cv::Mat picture = ReadPhoto((image_path_ / posed.name).string());
  const cv::Size size(posed.camera.width, posed.camera.height);
  if (picture.size() != size) {
    if (picture.cols < size.width) {
      throw Error((image_path_ / posed.name).string() + ": the photo changed while it was used");
    }
    cv::Mat scaled;
    cv::resize(picture, scaled, size, 0, 0, cv::INTER_AREA);
    picture = scaled;
  }
  const Camera& camera = model_.cameras.at(model_.images.at(posed.image_id).camera_id);
  if (IsPinhole(camera)) return picture;
  cv::Mat undistorted;
  cv::remap(picture, undistorted, UndistortMap(camera, posed.camera, ScaleOf(photo)), cv::noArray(),
            cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return undistorted;
}

Reconstruction PhotoSource::PinholeModel() const {
  Reconstruction pinhole = model_;
  pinhole.cameras.clear();
  for (std::size_t i = 0; i < photo_set_.photos.size(); ++i) {
    const PosedPhoto& posed = photo_set_.photos[i];
    SparseImage& image = pinhole.images.at(posed.image_id);
    const Camera& camera = model_.cameras.at(image.camera_id);
    for (Keypoint2D& keypoint : image.keypoints) {
      const auto normalized = NormalizedFromImage(camera, keypoint.pixel);
      // Where the distortion cannot be undone the corner stands in; no 3D point is seen there.
      keypoint.pixel = normalized ? posed.camera.Project(normalized->homogeneous())
                                  : Eigen::Vector2d(Eigen::Vector2d::Zero());
    }
    image.camera_id = static_cast<CameraId>(posed.image_id);
    pinhole.cameras[image.camera_id] = ToCamera(posed.camera);
  }
  return pinhole;
}

}  // namespace colmap_ext
