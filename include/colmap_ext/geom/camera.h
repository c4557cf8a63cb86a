// Camera models of COLMAP. Pixel coordinates are COLMAP's: (0, 0) is the upper left CORNER of the
// upper left pixel, whose centre is (0.5, 0.5).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace colmap_ext {

// Ids as in COLMAP's files (src/base/camera_models.h of 3.8).
enum class CameraModel {
  kSimplePinhole = 0,
  kPinhole = 1,
  kSimpleRadial = 2,
  kRadial = 3,
  kOpenCV = 4,
  kOpenCVFisheye = 5,
  kFullOpenCV = 6,
  kFOV = 7,
  kSimpleRadialFisheye = 8,
  kRadialFisheye = 9,
  kThinPrismFisheye = 10,
};

struct CameraModelInfo {
  CameraModel model;
  const char* name;  // "SIMPLE_PINHOLE" …
  int num_params;
};
// Parameters begin with so many focal lengths (1 or 2), then the principal point's two, then
// distortion.
int NumFocalParams(CameraModel model);
// The eleven models. Throws Error (naming the id or name) for an unknown one.
const CameraModelInfo& GetCameraModelInfo(int model_id);
const CameraModelInfo& GetCameraModelInfo(const std::string& model_name);

struct Camera {
  CameraModel model = CameraModel::kPinhole;
  int width = 0;               // px
  int height = 0;              // px
  std::vector<double> params;  // COLMAP's order; size = num_params of the model
};

// Ideal camera: u = fx x/z + cx, v = fy y/z + cy.
struct PinholeCamera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;  // px
  double cx = 0, cy = 0;  // px

  // Point in the camera frame (z > 0) to pixel.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_cam) const {
    return {fx * point_in_cam.x() / point_in_cam.z() + cx,
            fy * point_in_cam.y() / point_in_cam.z() + cy};
  }
  // Point on the ray of a pixel with z = 1 (not unit length).
  Eigen::Vector3d Ray(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy, 1.0};
  }
  // True inside the image, borders shrunk by margin_px.
  bool Contains(const Eigen::Vector2d& pixel, double margin_px = 0) const {
    return pixel.x() >= margin_px && pixel.y() >= margin_px && pixel.x() <= width - margin_px &&
           pixel.y() <= height - margin_px;
  }
};

// Normalised camera coordinates (x/z, y/z) to pixel, with the model's distortion. This and the
// functions below throw Error when the number of parameters is not the model's.
Eigen::Vector2d ImageFromNormalized(const Camera& camera, const Eigen::Vector2d& normalized);
// The same with its derivatives.
inline constexpr int kMaxCameraParams = 12;
struct ProjectionDerivatives {
  Eigen::Matrix2d by_normalized;
  Eigen::Matrix<double, 2, kMaxCameraParams> by_params;  // the first num_params columns are set
};
Eigen::Vector2d ImageFromNormalized(const Camera& camera, const Eigen::Vector2d& normalized,
                                    ProjectionDerivatives* derivatives);
// Inverse of the above; nullopt where the iteration does not converge, where the lens polynomial
// has folded over (no point joined to the centre maps there), and 90 degrees and more off a
// fisheye's axis.
std::optional<Eigen::Vector2d> NormalizedFromImage(const Camera& camera,
                                                   const Eigen::Vector2d& pixel);

// True for SIMPLE_PINHOLE and PINHOLE, and for a model whose distortion parameters are all zero.
// Never for a fisheye: without distortion it is equidistant, not a pinhole.
bool IsPinhole(const Camera& camera);
// The same focal lengths and principal point without distortion, at the same size.
PinholeCamera ToPinhole(const Camera& camera);
// Intrinsics of the same camera for photos of another size (each axis scaled by its own ratio).
PinholeCamera ScaleTo(const PinholeCamera& camera, int width, int height);
Camera ToCamera(const PinholeCamera& camera);

}  // namespace colmap_ext
