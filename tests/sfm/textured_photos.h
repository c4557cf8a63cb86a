// Photos of a textured box on textured ground with exact poses, made by homographies, so that sfm's
// tests need nothing but OpenCV.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/photo_metadata.h"

namespace colmap_ext::testing_support {

inline const PinholeCamera kTestCamera = {320, 240, 300, 300, 160, 120};
inline const GeoPosition kTestOrigin = {47.4, 8.5, 450};

// A textured rectangle: origin + u s + v t for 0 <= s <= width_m, 0 <= t <= height_m.
struct TexturedFace {
  Eigen::Vector3d origin, u, v;  // world; u, v of unit length
  cv::Mat texture;
};
inline constexpr double kTexelsPerMeter = 25;

// Noise of several scales: SIFT finds corners everywhere, and no two places look alike.
inline cv::Mat NoiseTexture(double width_m, double height_m, int seed) {
  const cv::Size size(static_cast<int>(width_m * kTexelsPerMeter),
                      static_cast<int>(height_m * kTexelsPerMeter));
  cv::RNG random(static_cast<std::uint64_t>(seed));
  cv::Mat sum(size, CV_32FC3, cv::Scalar::all(128));
  for (const int cell : {2, 4, 8, 16, 32}) {
    cv::Mat coarse(size.height / cell + 2, size.width / cell + 2, CV_32FC3), fine;
    random.fill(coarse, cv::RNG::UNIFORM, -40, 40);
    cv::resize(coarse, fine, size, 0, 0, cv::INTER_CUBIC);
    sum += fine;
  }
  cv::Mat texture;
  sum.convertTo(texture, CV_8UC3);
  return texture;
}

inline std::vector<TexturedFace> BoxOnGround() {
  using Eigen::Vector3d;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  return {
      {{-25, -25, 0}, x, y, NoiseTexture(50, 50, 1)}, {{-4, -3, 5}, x, y, NoiseTexture(8, 6, 2)},
      {{-4, -3, 0}, x, z, NoiseTexture(8, 5, 3)},     {{4, -3, 0}, y, z, NoiseTexture(6, 5, 4)},
      {{4, 3, 0}, -x, z, NoiseTexture(8, 5, 5)},      {{-4, 3, 0}, -y, z, NoiseTexture(6, 5, 6)}};
}

// Renders the faces, the first one (ground) below the others, which form a convex body.
inline cv::Mat RenderFaces(const std::vector<TexturedFace>& faces, const Rigid3d& cam_from_world) {
  constexpr int kOver = 2;  // samples a pixel and axis
  const PinholeCamera camera =
      ScaleTo(kTestCamera, kTestCamera.width * kOver, kTestCamera.height * kOver);
  cv::Mat picture(camera.height, camera.width, CV_8UC3, cv::Scalar::all(200));
  Eigen::Matrix3d intrinsics;
  // OpenCV's pixel centres are whole numbers, ours end in .5.
  intrinsics << camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1;
  for (const TexturedFace& face : faces) {
    const Eigen::Vector3d normal = face.u.cross(face.v);
    if (normal.dot(CameraCenter(cam_from_world) - face.origin) <= 0) continue;
    const double step = 1 / kTexelsPerMeter;
    Eigen::Matrix3d homography;
    homography.col(0) = intrinsics * (cam_from_world.rotation * face.u) * step;
    homography.col(1) = intrinsics * (cam_from_world.rotation * face.v) * step;
    homography.col(2) =
        intrinsics * (cam_from_world * (face.origin + 0.5 * step * (face.u + face.v)));
    cv::Matx33d matrix;
    for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = homography(i / 3, i % 3);
    cv::warpPerspective(face.texture, picture, matrix, picture.size(), cv::INTER_LINEAR,
                        cv::BORDER_TRANSPARENT);
  }
  cv::Mat small;
  cv::resize(picture, small, cv::Size(kTestCamera.width, kTestCamera.height), 0, 0, cv::INTER_AREA);
  return small;
}

// Photo `i` of an arc around the box: 8 degrees apart, 14 m away, 8 m high, looking at the box.
inline Rigid3d ArcPose(int i) {
  const double turn = DegToRad(8.0 * i);
  const Eigen::Vector3d position(14 * std::sin(turn), -14 * std::cos(turn), 8 + 0.3 * (i % 3));
  return CamFromWorld(position, {-turn, DegToRad(-27)});
}
inline std::string ArcName(int i) {
  return "photo_" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".jpg";
}

struct PhotoOptions {
  bool gps = true;
  bool focal = true;
};

inline void WriteArcPhotos(const std::filesystem::path& folder, int begin, int end,
                           const PhotoOptions& options = {}) {
  std::filesystem::create_directories(folder);
  static const std::vector<TexturedFace> faces = BoxOnGround();
  for (int i = begin; i < end; ++i) {
    const std::filesystem::path path = folder / ArcName(i);
    cv::imwrite(path.string(), RenderFaces(faces, ArcPose(i)), {cv::IMWRITE_JPEG_QUALITY, 95});
    PhotoMetadata metadata;
    metadata.camera_make = kSimulatedMake;
    metadata.camera_model = kSimulatedModel;
    if (options.focal) metadata.focal_px = kTestCamera.fx;
    if (options.gps) metadata.gps = GeoFromEnu(kTestOrigin, CameraCenter(ArcPose(i)));
    WritePhotoMetadata(metadata, path);
  }
}

}  // namespace colmap_ext::testing_support
