#include "point_colors.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

struct Sample {
  Point3DId point = kInvalidPoint3DId;
  Eigen::Vector3i rgb = Eigen::Vector3i::Zero();
};

std::vector<Sample> SamplePhoto(const std::filesystem::path& path, const SparseImage& image,
                                const std::set<Point3DId>& wanted) {
  std::vector<Sample> samples;
  const cv::Mat3b bgr = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (bgr.empty()) return samples;
  for (const Keypoint2D& keypoint : image.keypoints) {
    if (!wanted.contains(keypoint.point3D_id)) continue;
    const int x = std::clamp(static_cast<int>(std::floor(keypoint.pixel.x())), 0, bgr.cols - 1);
    const int y = std::clamp(static_cast<int>(std::floor(keypoint.pixel.y())), 0, bgr.rows - 1);
    const cv::Vec3b& color = bgr(y, x);
    samples.push_back({keypoint.point3D_id, {color[2], color[1], color[0]}});
  }
  return samples;
}

}  // namespace

void ColorPoints(const std::filesystem::path& image_path, const std::vector<std::string>& photos,
                 Reconstruction* model) {
  std::set<Point3DId> wanted;
  for (const auto& [id, point] : model->points) {
    if (point.color.isZero()) wanted.insert(id);
  }
  const std::set<std::string> names(photos.begin(), photos.end());
  std::vector<const SparseImage*> images;
  for (const auto& [id, image] : model->images) {
    if (names.contains(image.name)) images.push_back(&image);
  }
  std::vector<std::vector<Sample>> samples(images.size());
  ParallelFor(images.size(), [&](std::size_t i) {
    samples[i] = SamplePhoto(image_path / images[i]->name, *images[i], wanted);
  });
  struct Sum {
    Eigen::Vector3i rgb = Eigen::Vector3i::Zero();
    int count = 0;
  };
  std::map<Point3DId, Sum> sums;
  for (const std::vector<Sample>& of_photo : samples) {
    for (const Sample& sample : of_photo) {
      Sum& sum = sums[sample.point];
      sum.rgb += sample.rgb;
      ++sum.count;
    }
  }
  for (const auto& [id, sum] : sums) {
    model->points.at(id).color = (sum.rgb / sum.count).cast<std::uint8_t>();
  }
}

}  // namespace colmap_ext
