#include "colmap_ext/geom/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr std::array<CameraModelInfo, 11> kModels = {{
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3},
    {CameraModel::kPinhole, "PINHOLE", 4},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4},
    {CameraModel::kRadial, "RADIAL", 5},
    {CameraModel::kOpenCV, "OPENCV", 8},
    {CameraModel::kOpenCVFisheye, "OPENCV_FISHEYE", 8},
    {CameraModel::kFullOpenCV, "FULL_OPENCV", 12},
    {CameraModel::kFOV, "FOV", 5},
    {CameraModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", 4},
    {CameraModel::kRadialFisheye, "RADIAL_FISHEYE", 5},
    {CameraModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE", 12},
}};

// Focal lengths and principal point, and where the distortion parameters begin.
struct Intrinsics {
  double fx = 0, fy = 0;
  double cx = 0, cy = 0;
  const double* distortion = nullptr;
  std::size_t num_distortion = 0;
};

bool HasOneFocalLength(CameraModel model) {
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kSimpleRadial:
    case CameraModel::kRadial:
    case CameraModel::kSimpleRadialFisheye:
    case CameraModel::kRadialFisheye:
      return true;
    default:
      return false;
  }
}

Intrinsics IntrinsicsOf(const Camera& camera) {
  const CameraModelInfo& info = GetCameraModelInfo(static_cast<int>(camera.model));
  if (camera.params.size() != static_cast<std::size_t>(info.num_params)) {
    throw Error("camera model " + std::string(info.name) + " has " +
                std::to_string(info.num_params) + " parameters, not " +
                std::to_string(camera.params.size()));
  }
  const double* p = camera.params.data();
  const std::size_t n = camera.params.size();
  if (HasOneFocalLength(camera.model)) return {p[0], p[0], p[1], p[2], p + 3, n - 3};
  return {p[0], p[1], p[2], p[3], p + 4, n - 4};
}

// Every model but FOV is this one polynomial, over the normalised point itself or, for a fisheye,
// over the equidistant point (the angle from the optical axis, in the point's direction):
//   d = u (1 + n1 r² + n2 r⁴ + n3 r⁶ + n4 r⁸) / (1 + d1 r² + d2 r⁴ + d3 r⁶)
//     + decentring (p1, p2) + thin prism (s1, s2) r²
struct Polynomial {
  bool is_fisheye = false;
  double n1 = 0, n2 = 0, n3 = 0, n4 = 0;
  double d1 = 0, d2 = 0, d3 = 0;
  double p1 = 0, p2 = 0;
  double s1 = 0, s2 = 0;
};

Polynomial PolynomialOf(CameraModel model, const double* k) {
  Polynomial poly;
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
    case CameraModel::kFOV:
      break;
    case CameraModel::kSimpleRadialFisheye:
      poly.is_fisheye = true;
      [[fallthrough]];
    case CameraModel::kSimpleRadial:
      poly.n1 = k[0];
      break;
    case CameraModel::kRadialFisheye:
      poly.is_fisheye = true;
      [[fallthrough]];
    case CameraModel::kRadial:
      poly.n1 = k[0], poly.n2 = k[1];
      break;
    case CameraModel::kOpenCV:
      poly.n1 = k[0], poly.n2 = k[1], poly.p1 = k[2], poly.p2 = k[3];
      break;
    case CameraModel::kOpenCVFisheye:
      poly.is_fisheye = true;
      poly.n1 = k[0], poly.n2 = k[1], poly.n3 = k[2], poly.n4 = k[3];
      break;
    case CameraModel::kFullOpenCV:
      poly.n1 = k[0], poly.n2 = k[1], poly.p1 = k[2], poly.p2 = k[3], poly.n3 = k[4];
      poly.d1 = k[5], poly.d2 = k[6], poly.d3 = k[7];
      break;
    case CameraModel::kThinPrismFisheye:
      poly.is_fisheye = true;
      poly.n1 = k[0], poly.n2 = k[1], poly.p1 = k[2], poly.p2 = k[3];
      poly.n3 = k[4], poly.n4 = k[5], poly.s1 = k[6], poly.s2 = k[7];
      break;
  }
  return poly;
}

// Distorted point and, on demand, its derivative by `u`.
Eigen::Vector2d Distort(const Polynomial& poly, const Eigen::Vector2d& u,
                        Eigen::Matrix2d* jacobian) {
  const double r2 = u.squaredNorm();
  const double numerator = 1 + r2 * (poly.n1 + r2 * (poly.n2 + r2 * (poly.n3 + r2 * poly.n4)));
  const double denominator = 1 + r2 * (poly.d1 + r2 * (poly.d2 + r2 * poly.d3));
  const double radial = numerator / denominator;
  const Eigen::Vector2d swapped(poly.p2, poly.p1);
  const Eigen::Vector2d prism(poly.s1, poly.s2);
  // Decentring: x gets 2 p1 xy + p2 (r² + 2x²), y gets 2 p2 xy + p1 (r² + 2y²), which is
  // 2 (p2, p1)·u u + (p2, p1) r².
  const double along = swapped.dot(u);
  if (jacobian != nullptr) {
    const double d_numerator = poly.n1 + r2 * (2 * poly.n2 + r2 * (3 * poly.n3 + r2 * 4 * poly.n4));
    const double d_denominator = poly.d1 + r2 * (2 * poly.d2 + r2 * 3 * poly.d3);
    const double d_radial = (d_numerator - radial * d_denominator) / denominator;
    *jacobian = (radial + 2 * along) * Eigen::Matrix2d::Identity() +
                2 * d_radial * u * u.transpose() + 2 * u * swapped.transpose() +
                2 * (swapped + prism) * u.transpose();
  }
  return (radial + 2 * along) * u + (swapped + prism) * r2;
}

// Newton's method from *u. False when it does not converge.
bool SolveDistortion(const Polynomial& poly, const Eigen::Vector2d& target, Eigen::Vector2d* u) {
  constexpr int kMaxIterations = 50;
  constexpr double kTolerance = 1e-13;  // of normalised coordinates: 1e-9 px at any focal length
  const double wanted = kTolerance * (1 + target.norm());
  for (int i = 0; i < kMaxIterations; ++i) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d residual = Distort(poly, *u, &jacobian) - target;
    if (!residual.allFinite()) return false;
    if (residual.norm() <= wanted) return true;
    const double determinant = jacobian.determinant();
    if (!(std::abs(determinant) > 1e-12)) return false;
    *u -= jacobian.inverse() * residual;
  }
  return false;
}

// A strong lens polynomial folds over far from the centre, where one pixel has several solutions.
// The one that a real lens means is joined to the centre without crossing the fold.
bool IsBeforeFold(const Polynomial& poly, const Eigen::Vector2d& u) {
  constexpr int kSteps = 16;
  for (int i = 1; i <= kSteps; ++i) {
    Eigen::Matrix2d jacobian;
    Distort(poly, u * (static_cast<double>(i) / kSteps), &jacobian);
    if (!(jacobian.determinant() > 0)) return false;
  }
  return true;
}

std::optional<Eigen::Vector2d> Undistort(const Polynomial& poly, const Eigen::Vector2d& target) {
  Eigen::Vector2d u = target;
  if (SolveDistortion(poly, target, &u) && IsBeforeFold(poly, u)) return u;
  // Follow the solution outwards from the centre.
  constexpr int kSteps = 32;
  u.setZero();
  for (int i = 1; i <= kSteps; ++i) {
    if (!SolveDistortion(poly, target * (static_cast<double>(i) / kSteps), &u)) {
      return std::nullopt;
    }
  }
  if (!IsBeforeFold(poly, u)) return std::nullopt;
  return u;
}

// Direction of the point kept, its length r = tan(angle) replaced by the angle, and back.
Eigen::Vector2d EquidistantFromNormalized(const Eigen::Vector2d& normalized) {
  const double r = normalized.norm();
  // Below this, atan(r)/r is 1 to the last bit.
  if (r < 1e-9) return normalized;
  return normalized * (std::atan(r) / r);
}

std::optional<Eigen::Vector2d> NormalizedFromEquidistant(const Eigen::Vector2d& equidistant) {
  const double angle = equidistant.norm();
  if (angle < 1e-9) return equidistant;
  // At a right angle and beyond there is no point with z = 1.
  if (angle >= 1.5707963267948966 - 1e-9) return std::nullopt;
  return equidistant * (std::tan(angle) / angle);
}

// FOV model (Devernay and Faugeras 2001): r_distorted = atan(2 r tan(omega / 2)) / omega.
double FovRatio(double omega, double r) {
  const double a = 2 * std::tan(omega / 2);
  // Limits for omega -> 0 and r -> 0, both exact to the last bit below these bounds.
  if (std::abs(omega) < 1e-8) return 1;
  if (r < 1e-9) return a / omega;
  return std::atan(r * a) / (r * omega);
}

// FovRatio with its derivatives by omega and by r².
struct FovDerivatives {
  double ratio, by_omega, by_r2;
};
FovDerivatives DeriveFov(double omega, double r) {
  // Series where the closed forms cancel; what is left out is of fourth order.
  if (std::abs(omega) < 1e-3) {
    const double a_by_omega = 1 + omega * omega / 12;
    const double cubic = a_by_omega * a_by_omega * a_by_omega * omega * omega / 3;
    return {a_by_omega - cubic * r * r, omega / 6 - 2 * omega * r * r / 3, -cubic};
  }
  const double a = 2 * std::tan(omega / 2);
  if (r < 1e-4) {
    const double cubic = a * a * a / (3 * omega);
    return {a / omega - cubic * r * r, (1 + a * a / 4 - a / omega) / omega, -cubic};
  }
  const double slope = 1 / (1 + r * r * a * a);  // of atan at r a
  const double ratio = std::atan(r * a) / (r * omega);
  const double by_omega = (slope * (1 + a * a / 4) - ratio) / omega;
  const double by_r2 = (slope * a / omega - ratio) / (2 * r * r);
  return {ratio, by_omega, by_r2};
}

// Distorted point with derivatives by `normalized` and by the distortion parameters.
using DistortionDerivatives = Eigen::Matrix<double, 2, kMaxCameraParams>;
Eigen::Vector2d DeriveFovDistortion(double omega, const Eigen::Vector2d& normalized,
                                    Eigen::Matrix2d* by_normalized,
                                    DistortionDerivatives* by_distortion) {
  const FovDerivatives fov = DeriveFov(omega, normalized.norm());
  *by_normalized =
      fov.ratio * Eigen::Matrix2d::Identity() + 2 * fov.by_r2 * normalized * normalized.transpose();
  by_distortion->col(0) = fov.by_omega * normalized;
  return fov.ratio * normalized;
}

// Columns in the order of COLMAP's parameters.
void DerivePolynomial(CameraModel model, const Polynomial& poly, const Eigen::Vector2d& u,
                      DistortionDerivatives* by_distortion) {
  const double r2 = u.squaredNorm();
  const double denominator = 1 + r2 * (poly.d1 + r2 * (poly.d2 + r2 * poly.d3));
  const Eigen::Vector2d n1 = u * (r2 / denominator);
  const Eigen::Vector2d p1(2 * u.x() * u.y(), r2 + 2 * u.y() * u.y());
  const Eigen::Vector2d p2(r2 + 2 * u.x() * u.x(), 2 * u.x() * u.y());
  DistortionDerivatives& by = *by_distortion;
  by.col(0) = n1;
  by.col(1) = n1 * r2;
  switch (model) {
    case CameraModel::kOpenCVFisheye:
      by.col(2) = n1 * (r2 * r2);
      by.col(3) = n1 * (r2 * r2 * r2);
      return;
    case CameraModel::kOpenCV:
    case CameraModel::kFullOpenCV:
    case CameraModel::kThinPrismFisheye:
      by.col(2) = p1;
      by.col(3) = p2;
      break;
    default:
      return;
  }
  if (model == CameraModel::kOpenCV) return;
  by.col(4) = n1 * (r2 * r2);
  if (model == CameraModel::kThinPrismFisheye) {
    by.col(5) = n1 * (r2 * r2 * r2);
    by.col(6) = Eigen::Vector2d(r2, 0);
    by.col(7) = Eigen::Vector2d(0, r2);
    return;
  }
  const double numerator = 1 + r2 * (poly.n1 + r2 * (poly.n2 + r2 * poly.n3));
  by.col(5) = n1 * (-numerator / denominator);
  by.col(6) = by.col(5) * r2;
  by.col(7) = by.col(6) * r2;
}

Eigen::Vector2d DerivePolynomialDistortion(CameraModel model, const double* distortion,
                                           const Eigen::Vector2d& normalized,
                                           Eigen::Matrix2d* by_normalized,
                                           DistortionDerivatives* by_distortion) {
  const Polynomial poly = PolynomialOf(model, distortion);
  const Eigen::Vector2d u = poly.is_fisheye ? EquidistantFromNormalized(normalized) : normalized;
  const Eigen::Vector2d distorted = Distort(poly, u, by_normalized);
  DerivePolynomial(model, poly, u, by_distortion);
  const double r = normalized.norm();
  // Below this, the equidistant point is the normalised one to the last bit.
  if (poly.is_fisheye && r > 1e-6) {
    const double ratio = std::atan(r) / r;
    const Eigen::Matrix2d u_by_normalized =
        ratio * Eigen::Matrix2d::Identity() +
        ((1 / (1 + r * r) - ratio) / (r * r)) * normalized * normalized.transpose();
    *by_normalized = (*by_normalized * u_by_normalized).eval();
  }
  return distorted;
}

std::optional<Eigen::Vector2d> UndistortFov(double omega, const Eigen::Vector2d& distorted) {
  const double a = 2 * std::tan(omega / 2);
  const double r = distorted.norm();
  if (std::abs(omega) < 1e-8) return distorted;
  if (r < 1e-9) return distorted * (omega / a);
  if (std::abs(r * omega) >= 1.5707963267948966 - 1e-9) return std::nullopt;
  return distorted * (std::tan(r * omega) / (r * a));
}

}  // namespace

int NumFocalParams(CameraModel model) { return HasOneFocalLength(model) ? 1 : 2; }

const CameraModelInfo& GetCameraModelInfo(int model_id) {
  if (model_id < 0 || static_cast<std::size_t>(model_id) >= kModels.size()) {
    throw Error("unknown camera model id " + std::to_string(model_id) +
                " (known are 0 SIMPLE_PINHOLE to 10 THIN_PRISM_FISHEYE)");
  }
  return kModels[static_cast<std::size_t>(model_id)];
}

const CameraModelInfo& GetCameraModelInfo(const std::string& model_name) {
  const auto found = std::find_if(kModels.begin(), kModels.end(), [&](const CameraModelInfo& info) {
    return model_name == info.name;
  });
  if (found == kModels.end()) {
    throw Error("unknown camera model '" + model_name +
                "' (known are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, "
                "OPENCV_FISHEYE, FULL_OPENCV, FOV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, "
                "THIN_PRISM_FISHEYE)");
  }
  return *found;
}

Eigen::Vector2d ImageFromNormalized(const Camera& camera, const Eigen::Vector2d& normalized) {
  const Intrinsics in = IntrinsicsOf(camera);
  Eigen::Vector2d distorted;
  if (camera.model == CameraModel::kFOV) {
    distorted = normalized * FovRatio(in.distortion[0], normalized.norm());
  } else {
    const Polynomial poly = PolynomialOf(camera.model, in.distortion);
    distorted = Distort(poly, poly.is_fisheye ? EquidistantFromNormalized(normalized) : normalized,
                        nullptr);
  }
  return {in.fx * distorted.x() + in.cx, in.fy * distorted.y() + in.cy};
}

Eigen::Vector2d ImageFromNormalized(const Camera& camera, const Eigen::Vector2d& normalized,
                                    ProjectionDerivatives* derivatives) {
  const Intrinsics in = IntrinsicsOf(camera);
  DistortionDerivatives by_distortion;
  const Eigen::Vector2d distorted =
      camera.model == CameraModel::kFOV
          ? DeriveFovDistortion(in.distortion[0], normalized, &derivatives->by_normalized,
                                &by_distortion)
          : DerivePolynomialDistortion(camera.model, in.distortion, normalized,
                                       &derivatives->by_normalized, &by_distortion);
  const Eigen::Vector2d focal(in.fx, in.fy);
  derivatives->by_normalized = focal.asDiagonal() * derivatives->by_normalized;
  auto& by = derivatives->by_params;
  const int num_focal = NumFocalParams(camera.model);
  if (num_focal == 1) {
    by.col(0) = distorted;
  } else {
    by.leftCols<2>() = distorted.asDiagonal();
  }
  by.middleCols<2>(num_focal).setIdentity();
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(in.num_distortion); ++k) {
    by.col(num_focal + 2 + k) = focal.cwiseProduct(by_distortion.col(k));
  }
  return {in.fx * distorted.x() + in.cx, in.fy * distorted.y() + in.cy};
}

std::optional<Eigen::Vector2d> NormalizedFromImage(const Camera& camera,
                                                   const Eigen::Vector2d& pixel) {
  const Intrinsics in = IntrinsicsOf(camera);
  const Eigen::Vector2d distorted((pixel.x() - in.cx) / in.fx, (pixel.y() - in.cy) / in.fy);
  if (!distorted.allFinite()) return std::nullopt;
  if (camera.model == CameraModel::kFOV) return UndistortFov(in.distortion[0], distorted);
  const Polynomial poly = PolynomialOf(camera.model, in.distortion);
  const std::optional<Eigen::Vector2d> undistorted = Undistort(poly, distorted);
  if (!undistorted || !poly.is_fisheye) return undistorted;
  return NormalizedFromEquidistant(*undistorted);
}

bool IsPinhole(const Camera& camera) {
  // A fisheye without distortion is still no pinhole: it is equidistant.
  const Intrinsics in = IntrinsicsOf(camera);
  if (PolynomialOf(camera.model, in.distortion).is_fisheye) return false;
  return std::all_of(in.distortion, in.distortion + in.num_distortion,
                     [](double k) { return k == 0; });
}

PinholeCamera ToPinhole(const Camera& camera) {
  const Intrinsics in = IntrinsicsOf(camera);
  return {camera.width, camera.height, in.fx, in.fy, in.cx, in.cy};
}

PinholeCamera ScaleTo(const PinholeCamera& camera, int width, int height) {
  const double sx = static_cast<double>(width) / camera.width;
  const double sy = static_cast<double>(height) / camera.height;
  return {width, height, camera.fx * sx, camera.fy * sy, camera.cx * sx, camera.cy * sy};
}

Camera ToCamera(const PinholeCamera& camera) {
  return {CameraModel::kPinhole,
          camera.width,
          camera.height,
          {camera.fx, camera.fy, camera.cx, camera.cy}};
}

}  // namespace colmap_ext
