#include "mvs/photo_patch.h"

#include <algorithm>
#include <cmath>

namespace colmap_ext {
namespace {

using Samples = PhotoPatch::Samples;

constexpr int kColumns = 8;
constexpr int kRows = 4;
static_assert(kColumns * kRows == PhotoPatch::kSamples);

// Where the samples fall in the neighbour: pixel positions with whole numbers at pixel centres.
struct Warp {
  Samples u, v, inverse_z;
};

bool WarpSamples(const PhotoPatch& patch, const PatchPlane& plane, const PixelTransfer& transfer,
                 Warp* warp) {
  const Eigen::Matrix3f& m = transfer.matrix;
  const Eigen::Vector3f& b = transfer.shift;
  // The affine inverse depth folded into the linear map.
  const Eigen::Vector3f along_x = m.col(0) + b * (plane[1] / patch.radius);
  const Eigen::Vector3f along_y = m.col(1) + b * (plane[2] / patch.radius);
  const Eigen::Vector3f at_center =
      m.col(0) * patch.center.x() + m.col(1) * patch.center.y() + m.col(2) + b * plane[0];
  const Samples z = along_x.z() * patch.x + along_y.z() * patch.y + at_center.z();
  if (!(z.minCoeff() > 0)) return false;
  warp->inverse_z = z.inverse();
  warp->u = (along_x.x() * patch.x + along_y.x() * patch.y + at_center.x()) * warp->inverse_z;
  warp->v = (along_x.y() * patch.x + along_y.y() * patch.y + at_center.y()) * warp->inverse_z;
  warp->u -= 0.5F;
  warp->v -= 0.5F;
  return warp->u.minCoeff() >= 0 && warp->v.minCoeff() >= 0 &&
         warp->u.maxCoeff() < static_cast<float>(transfer.grey.cols - 1) &&
         warp->v.maxCoeff() < static_cast<float>(transfer.grey.rows - 1);
}

Samples Interpolate(const Warp& warp, const cv::Mat1f& grey) {
  Samples values;
  const auto stride = static_cast<std::ptrdiff_t>(grey.step1());
  const float* data = grey.ptr<float>();
  for (int k = 0; k < PhotoPatch::kSamples; ++k) {
    const int x = static_cast<int>(warp.u[k]);
    const int y = static_cast<int>(warp.v[k]);
    const float fx = warp.u[k] - static_cast<float>(x);
    const float fy = warp.v[k] - static_cast<float>(y);
    const float* p = data + y * stride + x;
    const float top = p[0] + fx * (p[1] - p[0]);
    const float bottom = p[stride] + fx * (p[stride + 1] - p[stride]);
    values[k] = top + fy * (bottom - top);
  }
  return values;
}

void InterpolateWithGradient(const Warp& warp, const cv::Mat1f& grey, Samples* values,
                             Samples* along_u, Samples* along_v) {
  const auto stride = static_cast<std::ptrdiff_t>(grey.step1());
  const float* data = grey.ptr<float>();
  for (int k = 0; k < PhotoPatch::kSamples; ++k) {
    const int x = static_cast<int>(warp.u[k]);
    const int y = static_cast<int>(warp.v[k]);
    const float fx = warp.u[k] - static_cast<float>(x);
    const float fy = warp.v[k] - static_cast<float>(y);
    const float* p = data + y * stride + x;
    const float top_step = p[1] - p[0];
    const float bottom_step = p[stride + 1] - p[stride];
    const float top = p[0] + fx * top_step;
    const float bottom = p[stride] + fx * bottom_step;
    (*values)[k] = top + fy * (bottom - top);
    (*along_u)[k] = top_step + fy * (bottom_step - top_step);
    (*along_v)[k] = bottom - top;
  }
}

// Mean, deviation (with noise) and correlation of a neighbour's values.
struct Correlation {
  float mean, deviation, value;
};

Correlation Correlate(const PhotoPatch& patch, const Samples& values) {
  const Samples weighted = patch.weight * values;
  Correlation result;
  result.mean = weighted.sum();
  const float variance = std::max(0.0F, (weighted * values).sum() - result.mean * result.mean);
  result.deviation = std::sqrt(variance + PhotoPatch::kNoiseVariance);
  result.value = (patch.pattern * values).sum() / (patch.deviation * result.deviation);
  return result;
}

// Half the sides of the pixel box around a triangle and a margin.
Eigen::Vector2d HalfBox(const Eigen::Vector2d corners[3], Eigen::Vector2d* center) {
  constexpr double kMarginPx = 2.0;
  constexpr double kSmallestPx = 4.0;
  constexpr double kLargestPx = 9.0;
  const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  *center = (corners[0] + corners[1] + corners[2]) / 3.0;
  const Eigen::Vector2d half = 0.5 * (high - low) + Eigen::Vector2d::Constant(kMarginPx);
  return half.cwiseMax(kSmallestPx).cwiseMin(kLargestPx);
}

// Of a pixel on another superpixel: less the more its colour differs.
float ForeignWeight(const ImageMesh& mesh, std::size_t t, int other, double color_sigma) {
  constexpr double kLeast = 1e-3;
  if (other < 0) return static_cast<float>(kLeast);
  const double difference =
      (mesh.mean_bgr[t] - mesh.mean_bgr[static_cast<std::size_t>(other)]).norm() /
      (std::sqrt(3.0) * color_sigma);
  return static_cast<float>(kLeast + 0.5 * std::exp(-0.5 * difference * difference));
}

}  // namespace

PhotoPatch MakePatch(const ViewMesh& mesh, const cv::Mat1i& triangle_at, const cv::Mat1f& grey,
                     int triangle, double color_sigma) {
  const auto t = static_cast<std::size_t>(triangle);
  Eigen::Vector2d corners[3];
  for (int k = 0; k < 3; ++k) {
    corners[k] = mesh.image.vertices_px[static_cast<std::size_t>(mesh.image.triangles[t][k])];
  }
  Eigen::Vector2d center;
  const Eigen::Vector2d half = HalfBox(corners, &center);
  PhotoPatch patch;
  patch.center = center.cast<float>();
  patch.radius = static_cast<float>(half.maxCoeff());
  const int columns = half.x() >= half.y() ? kColumns : kRows;
  const int rows = PhotoPatch::kSamples / columns;
  Samples values;
  int last_superpixel = mesh.image.superpixel[t];
  float last_weight = 1.0F;
  for (int k = 0; k < PhotoPatch::kSamples; ++k) {
    // Pixels, so that the photo itself need not be interpolated.
    const double dx = half.x() * ((2.0 * (k % columns) + 1.0) / columns - 1.0);
    const double dy = half.y() * ((2.0 * (k / columns) + 1.0) / rows - 1.0);
    const int x = std::clamp(static_cast<int>(center.x() + dx), 0, grey.cols - 1);
    const int y = std::clamp(static_cast<int>(center.y() + dy), 0, grey.rows - 1);
    patch.x[k] = static_cast<float>(x) + 0.5F - patch.center.x();
    patch.y[k] = static_cast<float>(y) + 0.5F - patch.center.y();
    values[k] = grey(y, x);
    const int other = triangle_at(y, x);
    const int superpixel = other < 0 ? -1 : mesh.image.superpixel[static_cast<std::size_t>(other)];
    if (superpixel != last_superpixel) {
      last_superpixel = superpixel;
      last_weight = superpixel == mesh.image.superpixel[t]
                        ? 1.0F
                        : ForeignWeight(mesh.image, t, other, color_sigma);
    }
    patch.weight[k] = last_weight;
  }
  patch.weight /= patch.weight.sum();
  values -= (patch.weight * values).sum();
  patch.pattern = patch.weight * values;
  patch.variance = (patch.pattern * values).sum();
  patch.deviation = std::sqrt(patch.variance + PhotoPatch::kNoiseVariance);
  return patch;
}

PatchPlane ToPatchPlane(const Eigen::Vector3d& plane_in_cam, const PinholeCamera& camera,
                        const PhotoPatch& patch) {
  const Eigen::Vector3d center_ray = camera.Ray(patch.center.cast<double>());
  return PatchPlane(static_cast<float>(plane_in_cam.dot(center_ray)),
                    static_cast<float>(plane_in_cam.x() / camera.fx) * patch.radius,
                    static_cast<float>(plane_in_cam.y() / camera.fy) * patch.radius);
}

Eigen::Vector3d FromPatchPlane(const PatchPlane& plane, const PinholeCamera& camera,
                               const PhotoPatch& patch) {
  const Eigen::Vector3d ray = camera.Ray(patch.center.cast<double>());
  const double x = static_cast<double>(plane[1] / patch.radius) * camera.fx;
  const double y = static_cast<double>(plane[2] / patch.radius) * camera.fy;
  return {x, y, static_cast<double>(plane[0]) - x * ray.x() - y * ray.y()};
}

PixelTransfer::PixelTransfer(const ViewLookup& view, const ViewLookup& neighbor,
                             cv::Mat1f grey_of_neighbor)
    : grey(std::move(grey_of_neighbor)) {
  const Rigid3d neighbor_from_view = neighbor.cam_from_world * view.world_from_cam;
  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Identity();
  intrinsics(0, 0) = neighbor.camera.fx;
  intrinsics(1, 1) = neighbor.camera.fy;
  intrinsics(0, 2) = neighbor.camera.cx;
  intrinsics(1, 2) = neighbor.camera.cy;
  Eigen::Matrix3d ray_from_pixel = Eigen::Matrix3d::Identity();
  ray_from_pixel(0, 0) = 1.0 / view.camera.fx;
  ray_from_pixel(1, 1) = 1.0 / view.camera.fy;
  ray_from_pixel(0, 2) = -view.camera.cx / view.camera.fx;
  ray_from_pixel(1, 2) = -view.camera.cy / view.camera.fy;
  matrix =
      (intrinsics * neighbor_from_view.rotation.toRotationMatrix() * ray_from_pixel).cast<float>();
  shift = (intrinsics * neighbor_from_view.translation).cast<float>();
}

float CompareInNeighbor(const PhotoPatch& patch, const PatchPlane& plane,
                        const PixelTransfer& transfer) {
  Warp warp;
  if (!WarpSamples(patch, plane, transfer, &warp)) return kUnseen;
  return Correlate(patch, Interpolate(warp, transfer.grey)).value;
}

float AddNormalEquations(const PhotoPatch& patch, const PatchPlane& plane,
                         const PixelTransfer& transfer, float min_correlation,
                         Eigen::Matrix3f* hessian, Eigen::Vector3f* gradient) {
  constexpr float kLeastVariance = 0.02F;  // of the residual
  Warp warp;
  if (!WarpSamples(patch, plane, transfer, &warp)) return kUnseen;
  Samples values, along_u, along_v;
  InterpolateWithGradient(warp, transfer.grey, &values, &along_u, &along_v);
  const Correlation correlation = Correlate(patch, values);
  if (correlation.value < min_correlation) return correlation.value;
  const Eigen::Vector3f& b = transfer.shift;
  // d(grey) / d(inverse depth), by the chain rule through u and v.
  const Samples slope =
      warp.inverse_z *
      (along_u * (b.x() - b.z() * (warp.u + 0.5F)) + along_v * (b.y() - b.z() * (warp.v + 0.5F))) /
      correlation.deviation;
  const Samples residual = (values - correlation.mean) / correlation.deviation -
                           patch.pattern / (patch.weight * patch.deviation);
  Samples jacobian[3] = {slope, slope * patch.x / patch.radius, slope * patch.y / patch.radius};
  for (Samples& column : jacobian) column -= (patch.weight * column).sum();
  const float information = static_cast<float>(PhotoPatch::kSamples) /
                            std::max(kLeastVariance, (patch.weight * residual * residual).sum());
  for (int r = 0; r < 3; ++r) {
    const Samples weighted = information * patch.weight * jacobian[r];
    (*gradient)[r] += (weighted * residual).sum();
    for (int c = 0; c <= r; ++c) {
      const float entry = (weighted * jacobian[c]).sum();
      (*hessian)(r, c) += entry;
      if (c != r) (*hessian)(c, r) += entry;
    }
  }
  return correlation.value;
}

}  // namespace colmap_ext
