#include "colmap_ext/geom/closest_point.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace colmap_ext {
namespace {

constexpr int kLeafSize = 4;

Eigen::Vector3d ClosestOnSegment(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  if (length2 == 0.0) return a;
  return a + std::clamp((query - a).dot(ab) / length2, 0.0, 1.0) * ab;
}

}  // namespace

Eigen::Vector3d ClosestPointOnTriangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d normal = ab.cross(ac);
  const double area2 = normal.squaredNorm();
  const Eigen::Vector3d aq = query - a;
  if (area2 > 0.0) {
    // Barycentric coordinates of the projection; all non-negative: it lies inside.
    const double v = aq.cross(ac).dot(normal) / area2;
    const double w = ab.cross(aq).dot(normal) / area2;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return a + v * ab + w * ac;
  }
  Eigen::Vector3d best = ClosestOnSegment(query, a, b);
  for (const Eigen::Vector3d& other :
       {ClosestOnSegment(query, b, c), ClosestOnSegment(query, c, a)}) {
    if ((other - query).squaredNorm() < (best - query).squaredNorm()) best = other;
  }
  return best;
}

ClosestPointIndex::ClosestPointIndex(const TriangleMesh& mesh) : mesh_(mesh) {
  const std::size_t count = mesh_.faces.size();
  if (count == 0) return;
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Eigen::Vector3d> centroids(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto corners = Corners(static_cast<int>(i));
    centroids[i] = (corners[0] + corners[1] + corners[2]) / 3.0;
  }
  nodes_.reserve(2 * count / kLeafSize + 1);
  Build(&centroids, 0, static_cast<int>(count));
}

std::array<Eigen::Vector3d, 3> ClosestPointIndex::Corners(int face) const {
  const Eigen::Vector3i& corners = mesh_.faces[static_cast<std::size_t>(face)];
  return {mesh_.vertices[static_cast<std::size_t>(corners[0])],
          mesh_.vertices[static_cast<std::size_t>(corners[1])],
          mesh_.vertices[static_cast<std::size_t>(corners[2])]};
}

void ClosestPointIndex::Build(std::vector<Eigen::Vector3d>* centroids, int begin, int end) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d centroid_box;
  for (int i = begin; i < end; ++i) {
    const int face = order_[static_cast<std::size_t>(i)];
    centroid_box.extend((*centroids)[static_cast<std::size_t>(face)]);
    for (const Eigen::Vector3d& corner : Corners(face)) box.extend(corner);
  }
  nodes_[index].box = box;
  if (end - begin <= kLeafSize) {
    nodes_[index].first = begin;
    nodes_[index].count = end - begin;
    return;
  }
  Eigen::Index axis = 0;
  centroid_box.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int a, int b) {
                     const double ca = (*centroids)[static_cast<std::size_t>(a)][axis];
                     const double cb = (*centroids)[static_cast<std::size_t>(b)][axis];
                     return ca < cb || (ca == cb && a < b);
                   });
  Build(centroids, begin, middle);
  nodes_[index].first = static_cast<int>(nodes_.size());
  Build(centroids, middle, end);
}

std::optional<ClosestPoint> ClosestPointIndex::Find(const Eigen::Vector3d& query,
                                                    double max_distance) const {
  if (nodes_.empty()) return std::nullopt;
  struct Entry {
    std::size_t node;
    double distance2;
  };
  std::array<Entry, 64> stack;  // deeper than any median-split tree of 2^31 primitives
  std::size_t depth = 0;
  stack[depth++] = {0, nodes_[0].box.squaredExteriorDistance(query)};
  ClosestPoint best;
  double best2 = max_distance * max_distance;
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (entry.distance2 >= best2) continue;
    const Node& node = nodes_[entry.node];
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int face = order_[static_cast<std::size_t>(i)];
      const auto corners = Corners(face);
      const Eigen::Vector3d position =
          ClosestPointOnTriangle(query, corners[0], corners[1], corners[2]);
      const double distance2 = (position - query).squaredNorm();
      if (distance2 < best2) {
        best2 = distance2;
        best.position = position;
        best.face = face;
      }
    }
    if (node.count > 0) continue;
    Entry near{entry.node + 1, nodes_[entry.node + 1].box.squaredExteriorDistance(query)};
    const auto right = static_cast<std::size_t>(node.first);
    Entry far{right, nodes_[right].box.squaredExteriorDistance(query)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  if (best.face < 0) return std::nullopt;
  best.distance = std::sqrt(best2);
  return best;
}

}  // namespace colmap_ext
