#include "colmap_ext/sim/simulated_camera.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "sim/noise.h"

namespace colmap_ext {
namespace {

// Bits that differ for each seed and view, the same in any order of calls.
std::uint32_t ViewBits(std::uint64_t seed, int view_id, std::uint32_t salt) {
  const auto low = static_cast<std::uint32_t>(seed), high = static_cast<std::uint32_t>(seed >> 32);
  return HashBits(HashBits(HashBits(low + salt) ^ high) ^ static_cast<std::uint32_t>(view_id));
}

// Gaussian by Box and Muller; the standard library's differs between implementations.
Eigen::Vector3d GpsNoise(std::uint32_t bits, double sigma_m) {
  Eigen::Vector3d noise;
  for (std::uint32_t k = 0; k < 3; ++k) {
    const double radius =
        std::sqrt(-2 * std::log(std::max(1e-7, static_cast<double>(HashUnit(bits, 2 * k)))));
    noise[static_cast<int>(k)] =
        sigma_m * radius * std::cos(2 * M_PI * static_cast<double>(HashUnit(bits, 2 * k + 1)));
  }
  return noise;
}

std::string EncodeJpeg(const cv::Mat& bgr, int quality, const std::filesystem::path& path) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw Error(path.string() + ": the photo cannot be encoded as JPEG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace

PinholeCamera SimulatedCameraOptions::LowCamera() const {
  return {width, height, focal_px, focal_px, width / 2.0, height / 2.0};
}

PinholeCamera SimulatedCameraOptions::FullCamera() const {
  return ScaleTo(LowCamera(), full_width, full_height);
}

SimulatedCamera::SimulatedCamera(const Renderer& renderer, const GeoPosition& origin,
                                 const SimulatedCameraOptions& options)
    : renderer_(renderer), origin_(origin), options_(options) {
  ThrowIfInvalid(options.Check());
}

CapturedPhoto SimulatedCamera::CapturePhoto(const PlannedView& view,
                                            const std::filesystem::path& jpeg_path,
                                            PhotoResolution resolution) const {
  const Eigen::Vector3d error = GpsNoise(ViewBits(options_.seed, view.id, 1), options_.gps_noise_m);
  return CapturePhoto(view, GeoFromEnu(origin_, view.position + error), jpeg_path, resolution);
}

CapturedPhoto SimulatedCamera::CapturePhoto(const PlannedView& view, const GeoPosition& gps,
                                            const std::filesystem::path& jpeg_path,
                                            PhotoResolution resolution) const {
  CapturedPhoto photo;
  photo.camera = resolution == PhotoResolution::kLow ? options_.LowCamera() : options_.FullCamera();
  photo.cam_from_world = CamFromWorld(view.position, view.direction);
  photo.gps = gps;

  const cv::Mat bgr =
      renderer_.Render(photo.camera, photo.cam_from_world, ViewBits(options_.seed, view.id, 2));
  PhotoMetadata metadata;
  metadata.gps = photo.gps;
  metadata.focal_px = photo.camera.fx;
  metadata.camera_make = kSimulatedMake;
  metadata.camera_model = kSimulatedModel;
  metadata.yaw_rad = view.direction.yaw_rad;
  metadata.pitch_rad = view.direction.pitch_rad;
  WriteFileAtomically(
      jpeg_path, WithPhotoMetadata(EncodeJpeg(bgr, options_.jpeg_quality, jpeg_path), metadata));
  return photo;
}

}  // namespace colmap_ext
