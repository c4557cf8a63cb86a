#include "surface/thinned_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kMinNormalLength = 1e-6;

// Cell of the grid and main direction of the normal (0 … 5: +x -x +y -y +z -z).
struct VoxelKey {
  std::int64_t x = 0, y = 0, z = 0;
  int direction = 0;
  auto operator<=>(const VoxelKey&) const = default;
};

VoxelKey CellOf(const Eigen::Vector3d& position, double cell_m) {
  const Eigen::Vector3d cell = (position / cell_m).array().floor();
  return {static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
          static_cast<std::int64_t>(cell.z()), 0};
}

int MainDirection(const Eigen::Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<int>(axis) + (normal[axis] < 0 ? 1 : 0);
}

struct KeyedPoint {
  VoxelKey key;
  int photo_index = -1;
  std::size_t index = 0;
  auto operator<=>(const KeyedPoint&) const = default;
};

// Sums of the points of one voxel.
class VoxelSum {
 public:
  void Add(const OrientedPoint& point) {
    const double weight = point.confidence;
    points_.push_back(&point);
    weight_ += weight;
    position_ += weight * point.position;
    normal_ += weight * point.normal.normalized();
    color_ += weight * point.color.cast<double>();
    if (photos_.empty() || photos_.back().photo_index != point.photo_index) {
      photos_.push_back({point.photo_index, 0});
    }
    photos_.back().weight += weight;
  }

  void AppendTo(ThinnedCloud* cloud) const {
    if (!(weight_ > 0) || normal_.norm() < kMinNormalLength * weight_) return;
    cloud->positions.push_back(position_ / weight_);
    cloud->normals.push_back(normal_.normalized());
    cloud->colors.push_back(color_ / (255.0 * weight_));
    cloud->photo_weights.insert(cloud->photo_weights.end(), photos_.begin(), photos_.end());
    cloud->photo_begin.push_back(cloud->photo_weights.size());
    cloud->squared_scatter.push_back(
        SquaredScatter(cloud->positions.back(), cloud->normals.back()));
  }

 private:
  double SquaredScatter(const Eigen::Vector3d& mean, const Eigen::Vector3d& normal) const {
    double sum = 0;
    for (const OrientedPoint* point : points_) {
      const double offset = normal.dot(point->position - mean);
      sum += point->confidence * offset * offset;
    }
    return sum / weight_;
  }

  std::vector<const OrientedPoint*> points_;
  double weight_ = 0;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d color_ = Eigen::Vector3d::Zero();
  std::vector<PhotoWeight> photos_;  // points come sorted by photo
};

}  // namespace

std::vector<std::size_t> UsablePoints(const OrientedPoints& points, const BoundingBox& box,
                                      double min_confidence) {
  std::vector<std::size_t> selected;
  selected.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const OrientedPoint& point = points[i];
    if (!point.position.allFinite() || !point.normal.allFinite() ||
        !std::isfinite(point.confidence)) {
      throw Error("point " + std::to_string(i) +
                  " of the fused cloud is not finite (position, normal or confidence)");
    }
    if (point.confidence <= 0 || point.confidence < min_confidence) continue;
    if (point.normal.norm() < kMinNormalLength || !box.contains(point.position)) continue;
    selected.push_back(i);
  }
  return selected;
}

double EstimateArea(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                    double cell_m) {
  std::vector<VoxelKey> cells;
  cells.reserve(selected.size());
  for (const std::size_t i : selected) cells.push_back(CellOf(points[i].position, cell_m));
  ParallelSort(&cells);
  const auto count = std::unique(cells.begin(), cells.end()) - cells.begin();
  // A plane of random orientation and area A meets about 1.5 A / cell² cells.
  return static_cast<double>(count) * cell_m * cell_m / 1.5;
}

ThinnedCloud ThinCloud(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                       double voxel_m) {
  std::vector<KeyedPoint> keyed;
  keyed.reserve(selected.size());
  for (const std::size_t i : selected) {
    KeyedPoint point{CellOf(points[i].position, voxel_m), points[i].photo_index, i};
    point.key.direction = MainDirection(points[i].normal);
    keyed.push_back(point);
  }
  ParallelSort(&keyed);  // by index last: no two are equal

  ThinnedCloud cloud;
  cloud.photo_begin.push_back(0);
  for (std::size_t begin = 0; begin < keyed.size();) {
    VoxelSum sum;
    std::size_t end = begin;
    for (; end < keyed.size() && keyed[end].key == keyed[begin].key; ++end) {
      sum.Add(points[keyed[end].index]);
    }
    sum.AppendTo(&cloud);
    begin = end;
  }
  return cloud;
}

}  // namespace colmap_ext
