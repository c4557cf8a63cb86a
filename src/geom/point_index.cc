#include "colmap_ext/geom/point_index.h"

#include <algorithm>
#include <cmath>
#include <flann/flann.hpp>
#include <utility>

namespace colmap_ext {
namespace {

using Distance = flann::L2_3D<double>;
using Tree = flann::KDTreeSingleIndex<Distance>;

}  // namespace

struct PointIndex::Impl {
  std::vector<double> coordinates;  // x y z of each point; the tree does not own them
  std::unique_ptr<Tree> tree;
};

PointIndex::PointIndex(const std::vector<Eigen::Vector3d>& points)
    : impl_(std::make_unique<Impl>()) {
  if (points.empty()) return;
  impl_->coordinates.reserve(3 * points.size());
  for (const Eigen::Vector3d& point : points) {
    impl_->coordinates.insert(impl_->coordinates.end(), {point.x(), point.y(), point.z()});
  }
  impl_->tree =
      std::make_unique<Tree>(flann::Matrix<double>(impl_->coordinates.data(), points.size(), 3),
                             flann::KDTreeSingleIndexParams(), Distance());
  impl_->tree->buildIndex();
}

PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

std::size_t PointIndex::NumPoints() const { return impl_->coordinates.size() / 3; }

std::optional<PointNeighbor> PointIndex::Nearest(const Eigen::Vector3d& query,
                                                 double max_distance) const {
  const std::vector<PointNeighbor> found = NearestOf(query, 1);
  if (found.empty() || !(found.front().distance < max_distance)) return std::nullopt;
  return found.front();
}

std::vector<PointNeighbor> PointIndex::NearestOf(const Eigen::Vector3d& query,
                                                 std::size_t count) const {
  count = std::min(count, NumPoints());
  if (count == 0) return {};
  flann::KNNSimpleResultSet<double> found(count);
  impl_->tree->findNeighbors(found, query.data(),
                             flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  std::vector<std::size_t> indices(count);
  std::vector<double> squared(count);
  found.copy(indices.data(), squared.data(), count, true);
  std::vector<PointNeighbor> neighbors(count);
  for (std::size_t i = 0; i < count; ++i) {
    neighbors[i] = {static_cast<int>(indices[i]), std::sqrt(squared[i])};
  }
  return neighbors;
}

}  // namespace colmap_ext
