#include "colmap_ext/dense/depth_filter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "colmap_ext/dense/pair_stereo.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr int kMinPlanePixels = 6;
constexpr float kOutlierFactor = 2.5F;
constexpr double kMinCosIncidence = 0.052;  // 87 degrees

// Inverse depth a + b du + c dv around a pixel.
struct Plane {
  float a = 0, b = 0, c = 0;
  int count = 0;
};

// Sums of the normal equations of a plane.
class PlaneFit {
 public:
  void Add(float u, float v, float h) {
    n_ += 1;
    u_ += u;
    v_ += v;
    uu_ += u * u;
    uv_ += u * v;
    vv_ += v * v;
    h_ += h;
    uh_ += u * h;
    vh_ += v * h;
  }

  // False when the pixels do not determine it.
  bool Solve(Plane* plane) const {
    if (n_ < kMinPlanePixels) return false;
    const float mean_u = u_ / n_, mean_v = v_ / n_, mean_h = h_ / n_;
    const float suu = uu_ - n_ * mean_u * mean_u, svv = vv_ - n_ * mean_v * mean_v;
    const float suv = uv_ - n_ * mean_u * mean_v;
    const float suh = uh_ - n_ * mean_u * mean_h, svh = vh_ - n_ * mean_v * mean_h;
    const float determinant = suu * svv - suv * suv;
    if (determinant < 0.05F * n_ * n_) return false;
    plane->b = (suh * svv - svh * suv) / determinant;
    plane->c = (svh * suu - suh * suv) / determinant;
    plane->a = mean_h - plane->b * mean_u - plane->c * mean_v;
    plane->count = static_cast<int>(n_);
    return true;
  }

 private:
  float n_ = 0, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0, vv_ = 0, h_ = 0, uh_ = 0, vh_ = 0;
};

// Calls visit(du, dv, offset of inverse depth from the centre's) for the like neighbours.
template <typename Visit>
void ForLikeNeighbors(const cv::Mat& inverse_depth, int x, int y, int radius, float max_error,
                      const Visit& visit) {
  const float center = inverse_depth.at<float>(y, x);
  const int y1 = std::min(inverse_depth.rows - 1, y + radius);
  const int x1 = std::min(inverse_depth.cols - 1, x + radius);
  for (int v = std::max(0, y - radius); v <= y1; ++v) {
    const float* row = inverse_depth.ptr<float>(v);
    for (int u = std::max(0, x - radius); u <= x1; ++u) {
      const float offset = row[u] - center;
      if (row[u] > 0 && std::abs(offset) <= max_error * center) {
        visit(static_cast<float>(u - x), static_cast<float>(v - y), offset);
      }
    }
  }
}

// The offset keeps float sums exact enough.
bool FitRobustPlane(const cv::Mat& inverse_depth, int x, int y, int radius, float max_error,
                    Plane* plane) {
  PlaneFit first;
  ForLikeNeighbors(inverse_depth, x, y, radius, max_error,
                   [&](float u, float v, float h) { first.Add(u, v, h); });
  Plane start;
  if (!first.Solve(&start)) return false;
  float sum = 0;
  const auto residual = [&](float u, float v, float h) {
    return std::abs(h - start.a - start.b * u - start.c * v);
  };
  ForLikeNeighbors(inverse_depth, x, y, radius, max_error,
                   [&](float u, float v, float h) { sum += residual(u, v, h); });
  const float limit = kOutlierFactor * sum / static_cast<float>(start.count) + 1e-12F;
  PlaneFit second;
  ForLikeNeighbors(inverse_depth, x, y, radius, max_error, [&](float u, float v, float h) {
    if (residual(u, v, h) <= limit) second.Add(u, v, h);
  });
  if (!second.Solve(plane)) return false;
  plane->a += inverse_depth.at<float>(y, x);
  return plane->a > 0;
}

// The plane n·X = 1 has 1/z = n·ray.
Eigen::Vector3d FacingNormal(const PinholeCamera& camera, const Plane& plane,
                             const Eigen::Vector3d& ray) {
  const double gx = camera.fx * static_cast<double>(plane.b);
  const double gy = camera.fy * static_cast<double>(plane.c);
  return -Eigen::Vector3d(gx, gy, plane.a - gx * ray.x() - gy * ray.y()).normalized();
}

bool IsKept(int confirming, int contradicting, int min_photos) {
  return 1 + confirming >= min_photos && contradicting <= confirming;
}

}  // namespace

DepthWitness AskWitness(const DepthView& view, const Eigen::Vector2d& pixel,
                        const Eigen::Vector3d& point_in_world, const DepthView& other,
                        const DenseStereoOptions& options) {
  DepthWitness witness;
  const Eigen::Vector3d in_other = other.cam_from_world * point_in_world;
  if (!(in_other.z() > 0)) return witness;
  const Eigen::Vector2d target = other.camera.Project(in_other);
  if (!other.camera.Contains(target)) return witness;
  const float inverse_depth = SampleSmooth(other.inverse_depth, target.x() - 0.5, target.y() - 0.5,
                                           options.max_depth_error);
  if (!(inverse_depth > 0)) return witness;
  const double depth = 1.0 / inverse_depth;
  const double difference = (depth - in_other.z()) / in_other.z();
  if (difference > 3 * options.max_depth_error) {
    witness.verdict = DepthWitness::Verdict::kContradicts;
    return witness;
  }
  if (std::abs(difference) > options.max_depth_error) return witness;
  const Eigen::Vector3d point = Inverse(other.cam_from_world) * (other.camera.Ray(target) * depth);
  const Eigen::Vector3d back = view.cam_from_world * point;
  if (!(back.z() > 0)) return witness;
  if ((view.camera.Project(back) - pixel).norm() > options.max_reprojection_px) return witness;
  witness.verdict = DepthWitness::Verdict::kConfirms;
  witness.point_in_world = point;
  witness.depth = depth;
  return witness;
}

ConfirmedDepth ConfirmDepth(const DepthView& view, const std::vector<DepthView>& others,
                            const DenseStereoOptions& options) {
  const cv::Size size = view.inverse_depth.size();
  ConfirmedDepth confirmed{cv::Mat::zeros(size, CV_32F), cv::Mat::zeros(size, CV_8U)};
  const Rigid3d world_from_cam = Inverse(view.cam_from_world);
  ParallelFor(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const float inverse_depth = view.inverse_depth.at<float>(y, x);
      if (!(inverse_depth > 0)) continue;
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      const Eigen::Vector3d point = world_from_cam * (view.camera.Ray(pixel) / inverse_depth);
      int confirming = 0, contradicting = 0;
      for (const DepthView& other : others) {
        const auto verdict = AskWitness(view, pixel, point, other, options).verdict;
        confirming += verdict == DepthWitness::Verdict::kConfirms;
        contradicting += verdict == DepthWitness::Verdict::kContradicts;
      }
      if (!IsKept(confirming, contradicting, options.min_photos)) continue;
      confirmed.inverse_depth.at<float>(y, x) = inverse_depth;
      confirmed.photos.at<unsigned char>(y, x) =
          static_cast<unsigned char>(std::min(255, 1 + confirming));
    }
  });
  return confirmed;
}

PlaneMaps FitPlanes(const PinholeCamera& camera, const cv::Mat& inverse_depth,
                    const DenseStereoOptions& options) {
  PlaneMaps maps{cv::Mat::zeros(inverse_depth.size(), CV_32F),
                 cv::Mat::zeros(inverse_depth.size(), CV_32FC3)};
  const int radius = options.plane_window_px / 2;
  const auto max_error = static_cast<float>(options.max_depth_error);
  ParallelFor(inverse_depth.rows, [&](int y) {
    for (int x = 0; x < inverse_depth.cols; ++x) {
      if (!(inverse_depth.at<float>(y, x) > 0)) continue;
      Plane plane;
      if (!FitRobustPlane(inverse_depth, x, y, radius, max_error, &plane)) continue;
      const Eigen::Vector3d ray = camera.Ray({x + 0.5, y + 0.5});
      const Eigen::Vector3d normal = FacingNormal(camera, plane, ray);
      if (!(-normal.dot(ray.normalized()) > kMinCosIncidence)) continue;
      maps.inverse_depth.at<float>(y, x) = plane.a;
      maps.normal.at<cv::Vec3f>(y, x) = {static_cast<float>(normal.x()),
                                         static_cast<float>(normal.y()),
                                         static_cast<float>(normal.z())};
    }
  });
  return maps;
}

}  // namespace colmap_ext
