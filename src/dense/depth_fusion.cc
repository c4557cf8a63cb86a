#include "colmap_ext/dense/depth_fusion.h"

#include <algorithm>

namespace colmap_ext {
namespace {

// Size of a pixel on a surface seen at right angles, in the unit of the world.
double PixelSize(const DepthView& view, double depth) { return depth / view.camera.fx; }

bool IsFiner(double size_a, int photo_a, double size_b, int photo_b) {
  return size_a < size_b || (size_a == size_b && photo_a < photo_b);
}

// False when another view gives the point.
bool MeanPosition(const FusionView& view, const std::vector<FusionView>& others,
                  const Eigen::Vector2d& pixel, double depth, const DenseStereoOptions& options,
                  Eigen::Vector3d* position) {
  const Eigen::Vector3d point =
      Inverse(view.depth.cam_from_world) * (view.depth.camera.Ray(pixel) * depth);
  const double size = PixelSize(view.depth, depth);
  double weight_sum = 1 / (size * size);
  Eigen::Vector3d sum = weight_sum * point;
  for (const FusionView& other : others) {
    const DepthWitness witness = AskWitness(view.depth, pixel, point, other.depth, options);
    if (witness.verdict != DepthWitness::Verdict::kConfirms) continue;
    const double other_size = PixelSize(other.depth, witness.depth);
    if (IsFiner(other_size, other.photo_index, size, view.photo_index)) return false;
    const double weight = 1 / (other_size * other_size);
    sum += weight * witness.point_in_world;
    weight_sum += weight;
  }
  *position = sum / weight_sum;
  return true;
}

}  // namespace

OrientedPoints FuseView(const FusionView& view, const std::vector<FusionView>& others,
                        const DenseStereoOptions& options) {
  OrientedPoints points;
  const Eigen::Quaterniond world_from_cam = view.depth.cam_from_world.rotation.inverse();
  const cv::Mat& map = view.depth.inverse_depth;
  for (int y = options.fusion_step_px / 2; y < map.rows; y += options.fusion_step_px) {
    for (int x = options.fusion_step_px / 2; x < map.cols; x += options.fusion_step_px) {
      const float inverse_depth = map.at<float>(y, x);
      if (!(inverse_depth > 0)) continue;
      OrientedPoint point;
      if (!MeanPosition(view, others, {x + 0.5, y + 0.5}, 1.0 / inverse_depth, options,
                        &point.position)) {
        continue;
      }
      const cv::Vec3f& normal = view.normal.at<cv::Vec3f>(y, x);
      point.normal = world_from_cam * Eigen::Vector3d(normal[0], normal[1], normal[2]);
      if (!view.bgr.empty()) {
        const cv::Vec3b& bgr = view.bgr.at<cv::Vec3b>(y, x);
        point.color = {bgr[2], bgr[1], bgr[0]};
      }
      const int photos = std::max<int>(1, view.photos.at<unsigned char>(y, x));
      point.confidence = 1.0F - 1.0F / static_cast<float>(photos);
      point.photo_index = view.photo_index;
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace colmap_ext
