#include "mvs/photo_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mvs/simd_lanes.h"

namespace colmap_ext {
namespace {

using Samples = PhotoPatch::Samples;

constexpr int kColumns = 8;
constexpr int kRows = 4;
static_assert(kColumns * kRows == PhotoPatch::kSamples);

constexpr int kBlocks = PhotoPatch::kSamples / kLanes;

// Pixel (x, y) of the view, about the patch's centre, falls on column · (x, y, 1) of the neighbour,
// divided by its third coordinate: the affine inverse depth is folded into the linear map.
struct PatchWarp {
  PatchWarp(const PhotoPatch& patch, const PatchPlane& plane, const PixelTransfer& transfer)
      : along_x(transfer.matrix.col(0) + transfer.shift * (plane[1] / patch.radius)),
        along_y(transfer.matrix.col(1) + transfer.shift * (plane[2] / patch.radius)),
        at_center(transfer.matrix.col(0) * patch.center.x() +
                  transfer.matrix.col(1) * patch.center.y() + transfer.matrix.col(2) +
                  transfer.shift * plane[0]) {}
  Eigen::Vector3f along_x, along_y, at_center;
};

// Where the samples fall in the neighbour: pixel positions with whole numbers at pixel centres.
struct WarpedSamples {
  FloatLanes u[kBlocks], v[kBlocks], inverse_z[kBlocks];
};

inline __attribute__((always_inline)) FloatLanesAt& Lanes(Samples& samples, int block) {
  return reinterpret_cast<FloatLanesAt&>(samples[block * kLanes]);
}
inline __attribute__((always_inline)) const FloatLanesAt& Lanes(const Samples& samples, int block) {
  return reinterpret_cast<const FloatLanesAt&>(samples[block * kLanes]);
}

// False when a sample falls outside of the neighbour or behind it.
inline __attribute__((always_inline)) bool WarpSamples(const PhotoPatch& patch,
                                                       const PatchWarp& warp, const cv::Mat1i& grey,
                                                       WarpedSamples* samples) {
  const float u_end = static_cast<float>(grey.cols - 1);
  const float v_end = static_cast<float>(grey.rows - 1);
  IntLanes inside = ~IntLanes{};
  for (int b = 0; b < kBlocks; ++b) {
    const FloatLanes x = Lanes(patch.x, b);
    const FloatLanes y = Lanes(patch.y, b);
    const FloatLanes z = warp.along_x.z() * x + warp.along_y.z() * y + warp.at_center.z();
    const FloatLanes inverse_z = 1.0F / z;
    const FloatLanes u =
        (warp.along_x.x() * x + warp.along_y.x() * y + warp.at_center.x()) * inverse_z - 0.5F;
    const FloatLanes v =
        (warp.along_x.y() * x + warp.along_y.y() * y + warp.at_center.y()) * inverse_z - 0.5F;
    inside &= (z > 0.0F) & (u >= 0.0F) & (v >= 0.0F) & (u < u_end) & (v < v_end);
    samples->u[b] = u;
    samples->v[b] = v;
    samples->inverse_z[b] = inverse_z;
  }
  std::int32_t all = -1;
  for (int l = 0; l < kLanes; ++l) all &= inside[l];
  return all != 0;
}

// Bilinear interpolation at the samples of a block: the four pixels around, and how far to go.
struct Quads {
  FloatLanes here, right, below, diagonal, x, y;
};

inline __attribute__((always_inline)) void LoadQuads(const WarpedSamples& samples, int block,
                                                     const cv::Mat1i& grey, Quads* quads) {
  const IntLanes column = __builtin_convertvector(samples.u[block], IntLanes);
  const IntLanes row = __builtin_convertvector(samples.v[block], IntLanes);
  const IntLanes index = row * static_cast<std::int32_t>(grey.step1()) + column;
  const int* data = grey.ptr<int>();
  IntLanes packed;
  for (int l = 0; l < kLanes; ++l) packed[l] = data[index[l]];
  quads->here = __builtin_convertvector(packed & 255, FloatLanes);
  quads->right = __builtin_convertvector((packed >> 8) & 255, FloatLanes);
  quads->below = __builtin_convertvector((packed >> 16) & 255, FloatLanes);
  quads->diagonal = __builtin_convertvector((packed >> 24) & 255, FloatLanes);
  quads->x = samples.u[block] - __builtin_convertvector(column, FloatLanes);
  quads->y = samples.v[block] - __builtin_convertvector(row, FloatLanes);
}

// Mean, deviation (with noise) and correlation of a neighbour's values.
struct Correlation {
  float mean, deviation, value;
};

// Sums over the samples of a neighbour's values.
struct ValueSums {
  FloatLanes value{}, square{}, product{};

  inline __attribute__((always_inline)) void Add(const PhotoPatch& patch, int block,
                                                 const FloatLanes& values) {
    const FloatLanes weighted = Lanes(patch.weight, block) * values;
    value += weighted;
    square += weighted * values;
    product += Lanes(patch.pattern, block) * values;
  }
  inline __attribute__((always_inline)) Correlation Correlate(const PhotoPatch& patch) const {
    Correlation result;
    result.mean = SumOfLanes(value);
    const float variance = std::max(0.0F, SumOfLanes(square) - result.mean * result.mean);
    result.deviation = std::sqrt(variance + PhotoPatch::kNoiseVariance);
    result.value = SumOfLanes(product) / (patch.deviation * result.deviation);
    return result;
  }
};

inline __attribute__((always_inline)) float CompareBody(const PhotoPatch& patch,
                                                        const PatchWarp& warp,
                                                        const cv::Mat1i& grey) {
  WarpedSamples samples;
  if (!WarpSamples(patch, warp, grey, &samples)) return kUnseen;
  ValueSums sums;
  for (int b = 0; b < kBlocks; ++b) {
    Quads quads;
    LoadQuads(samples, b, grey, &quads);
    const FloatLanes top = quads.here + quads.x * (quads.right - quads.here);
    const FloatLanes bottom = quads.below + quads.x * (quads.diagonal - quads.below);
    sums.Add(patch, b, top + quads.y * (bottom - top));
  }
  return sums.Correlate(patch).value;
}

// The normal equations' distinct entries, row after row of the lower triangle, and the gradient.
struct NormalSums {
  float hessian[6] = {}, gradient[3] = {};
};

inline __attribute__((always_inline)) float NormalBody(const PhotoPatch& patch,
                                                       const PatchWarp& warp,
                                                       const PixelTransfer& transfer,
                                                       float min_correlation, NormalSums* normal) {
  constexpr float kLeastVariance = 0.02F;  // of the residual
  WarpedSamples samples;
  if (!WarpSamples(patch, warp, transfer.grey, &samples)) return kUnseen;
  FloatLanes values[kBlocks], slope[kBlocks];
  ValueSums sums;
  const float bx = transfer.shift.x(), by = transfer.shift.y(), bz = transfer.shift.z();
  for (int b = 0; b < kBlocks; ++b) {
    Quads quads;
    LoadQuads(samples, b, transfer.grey, &quads);
    const FloatLanes top_step = quads.right - quads.here;
    const FloatLanes bottom_step = quads.diagonal - quads.below;
    const FloatLanes top = quads.here + quads.x * top_step;
    const FloatLanes along_v = quads.below + quads.x * bottom_step - top;
    const FloatLanes along_u = top_step + quads.y * (bottom_step - top_step);
    values[b] = top + quads.y * along_v;
    sums.Add(patch, b, values[b]);
    // d(grey) / d(inverse depth), by the chain rule through u and v.
    slope[b] = samples.inverse_z[b] * (along_u * (bx - bz * (samples.u[b] + 0.5F)) +
                                       along_v * (by - bz * (samples.v[b] + 0.5F)));
  }
  const Correlation correlation = sums.Correlate(patch);
  if (correlation.value < min_correlation) return correlation.value;
  const float scale = 1.0F / correlation.deviation;
  const float inverse_radius = 1.0F / patch.radius;
  FloatLanes jacobian[3][kBlocks], mean[3] = {}, residual[kBlocks], square{};
  for (int b = 0; b < kBlocks; ++b) {
    const FloatLanes weight = Lanes(patch.weight, b);
    jacobian[0][b] = slope[b] * scale;
    jacobian[1][b] = jacobian[0][b] * Lanes(patch.x, b) * inverse_radius;
    jacobian[2][b] = jacobian[0][b] * Lanes(patch.y, b) * inverse_radius;
    for (int r = 0; r < 3; ++r) mean[r] += weight * jacobian[r][b];
    residual[b] = (values[b] - correlation.mean) * scale -
                  Lanes(patch.pattern, b) / (weight * patch.deviation);
    square += weight * residual[b] * residual[b];
  }
  const float means[3] = {SumOfLanes(mean[0]), SumOfLanes(mean[1]), SumOfLanes(mean[2])};
  FloatLanes hessian[6] = {}, gradient[3] = {};
  for (int b = 0; b < kBlocks; ++b) {
    for (int r = 0; r < 3; ++r) jacobian[r][b] -= means[r];
    for (int r = 0; r < 3; ++r) {
      const FloatLanes weighted = Lanes(patch.weight, b) * jacobian[r][b];
      gradient[r] += weighted * residual[b];
      for (int c = 0; c <= r; ++c) hessian[r * (r + 1) / 2 + c] += weighted * jacobian[c][b];
    }
  }
  const float information =
      static_cast<float>(PhotoPatch::kSamples) / std::max(kLeastVariance, SumOfLanes(square));
  for (int i = 0; i < 6; ++i) normal->hessian[i] = information * SumOfLanes(hessian[i]);
  for (int i = 0; i < 3; ++i) normal->gradient[i] = information * SumOfLanes(gradient[i]);
  return correlation.value;
}

float ComparePlainly(const PhotoPatch& patch, const PatchWarp& warp, const cv::Mat1i& grey) {
  return CompareBody(patch, warp, grey);
}
COLMAP_EXT_TARGET_AVX2 float CompareWithAvx2(const PhotoPatch& patch, const PatchWarp& warp,
                                             const cv::Mat1i& grey) {
  return CompareBody(patch, warp, grey);
}
float NormalsPlainly(const PhotoPatch& patch, const PatchWarp& warp, const PixelTransfer& transfer,
                     float min_correlation, NormalSums* normal) {
  return NormalBody(patch, warp, transfer, min_correlation, normal);
}
COLMAP_EXT_TARGET_AVX2 float NormalsWithAvx2(const PhotoPatch& patch, const PatchWarp& warp,
                                             const PixelTransfer& transfer, float min_correlation,
                                             NormalSums* normal) {
  return NormalBody(patch, warp, transfer, min_correlation, normal);
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

// Of the pixels of other superpixels: less the more their colour differs.
class ForeignWeights {
 public:
  ForeignWeights(const ImageMesh& mesh, std::size_t t, double color_sigma)
      : mesh_(mesh), t_(t), color_sigma_(color_sigma) {
    known_[0] = {mesh.superpixel[t], 1.0F};
  }

  float Of(int triangle) {
    const int superpixel = triangle < 0 ? -1 : mesh_.superpixel[static_cast<std::size_t>(triangle)];
    for (std::size_t i = 0; i < count_; ++i) {
      if (known_[i].superpixel == superpixel) return known_[i].weight;
    }
    const std::size_t slot = count_ < known_.size() ? count_++ : count_ - 1;
    known_[slot] = {superpixel, Compute(triangle)};
    return known_[slot].weight;
  }

 private:
  struct Known {
    int superpixel;
    float weight;
  };

  float Compute(int triangle) const {
    constexpr double kLeast = 1e-3;
    if (triangle < 0) return static_cast<float>(kLeast);
    const double difference =
        (mesh_.mean_bgr[t_] - mesh_.mean_bgr[static_cast<std::size_t>(triangle)]).norm() /
        (std::sqrt(3.0) * color_sigma_);
    return static_cast<float>(kLeast + 0.5 * std::exp(-0.5 * difference * difference));
  }

  const ImageMesh& mesh_;
  std::size_t t_;
  double color_sigma_;
  std::array<Known, 12> known_;
  std::size_t count_ = 1;
};

}  // namespace

cv::Mat1i PackGrey(const cv::Mat& bgr) {
  cv::Mat1b grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {5, 5}, 0.8);
  cv::Mat1i packed(grey.size());
  for (int y = 0; y < grey.rows; ++y) {
    const std::uint8_t* top = grey.ptr(y);
    const std::uint8_t* bottom = grey.ptr(std::min(y + 1, grey.rows - 1));
    int* out = packed.ptr<int>(y);
    const auto pack = [&](int x, int right) {
      return static_cast<int>(static_cast<std::uint32_t>(top[x]) |
                              static_cast<std::uint32_t>(top[right]) << 8 |
                              static_cast<std::uint32_t>(bottom[x]) << 16 |
                              static_cast<std::uint32_t>(bottom[right]) << 24);
    };
    for (int x = 0; x + 1 < grey.cols; ++x) out[x] = pack(x, x + 1);
    out[grey.cols - 1] = pack(grey.cols - 1, grey.cols - 1);
  }
  return packed;
}

PhotoPatch MakePatch(const ViewMesh& mesh, const cv::Mat1i& triangle_at, const cv::Mat1i& grey,
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
  // Pixels, so that the photo itself need not be interpolated.
  int column_px[kColumns];
  for (int c = 0; c < columns; ++c) {
    const double offset = half.x() * ((2.0 * c + 1.0) / columns - 1.0);
    column_px[c] = std::clamp(static_cast<int>(center.x() + offset), 0, grey.cols - 1);
  }
  ForeignWeights weights(mesh.image, t, color_sigma);
  Samples values;
  for (int r = 0, k = 0; r < rows; ++r) {
    const double offset = half.y() * ((2.0 * r + 1.0) / rows - 1.0);
    const int y = std::clamp(static_cast<int>(center.y() + offset), 0, grey.rows - 1);
    const int* grey_row = grey.ptr<int>(y);
    const int* triangle_row = triangle_at.ptr<int>(y);
    for (int c = 0; c < columns; ++c, ++k) {
      const int x = column_px[c];
      patch.x[k] = static_cast<float>(x) + 0.5F - patch.center.x();
      patch.y[k] = static_cast<float>(y) + 0.5F - patch.center.y();
      values[k] = static_cast<float>(grey_row[x] & 255);
      patch.weight[k] = weights.Of(triangle_row[x]);
    }
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
                             cv::Mat1i grey_of_neighbor)
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
  const PatchWarp warp(patch, plane, transfer);
  return HasAvx2() ? CompareWithAvx2(patch, warp, transfer.grey)
                   : ComparePlainly(patch, warp, transfer.grey);
}

float AddNormalEquations(const PhotoPatch& patch, const PatchPlane& plane,
                         const PixelTransfer& transfer, float min_correlation,
                         Eigen::Matrix3f* hessian, Eigen::Vector3f* gradient) {
  const PatchWarp warp(patch, plane, transfer);
  NormalSums normal;
  const float correlation = HasAvx2()
                                ? NormalsWithAvx2(patch, warp, transfer, min_correlation, &normal)
                                : NormalsPlainly(patch, warp, transfer, min_correlation, &normal);
  for (int r = 0; r < 3; ++r) {
    (*gradient)[r] += normal.gradient[r];
    for (int c = 0; c < 3; ++c) {
      const int high = std::max(r, c), low = std::min(r, c);
      (*hessian)(r, c) += normal.hessian[high * (high + 1) / 2 + low];
    }
  }
  return correlation;
}

}  // namespace colmap_ext
