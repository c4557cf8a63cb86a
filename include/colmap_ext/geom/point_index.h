// Nearest neighbours among points (FLANN, exact search).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace colmap_ext {

struct PointNeighbor {
  int index = -1;  // of the point
  double distance = 0;
};

// k-d tree over points, in double precision. Immutable after construction; all queries may be
// called from many threads, and have one answer whatever their number.
class PointIndex {
 public:
  explicit PointIndex(const std::vector<Eigen::Vector3d>& points);
  ~PointIndex();
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;

  // The nearest point closer than `max_distance`; nullopt when there is none.
  std::optional<PointNeighbor> Nearest(
      const Eigen::Vector3d& query,
      double max_distance = std::numeric_limits<double>::infinity()) const;

  // The `count` nearest points (all when there are fewer), nearest first.
  std::vector<PointNeighbor> NearestOf(const Eigen::Vector3d& query, std::size_t count) const;

  std::size_t NumPoints() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
