#include "path/face_clusters.h"

#include <algorithm>
#include <numeric>

namespace colmap_ext {
namespace {

using Faces = std::vector<std::uint32_t>;

// Halves the faces across the longest side of their centroids' box until the parts are small
// enough; calls `take(begin, end)` for each part.
template <typename Take>
void Halve(const std::vector<Eigen::Vector3d>& centroids, std::size_t most, Faces::iterator begin,
           Faces::iterator end, const Take& take) {
  if (static_cast<std::size_t>(end - begin) <= most) {
    take(begin, end);
    return;
  }
  Eigen::AlignedBox3d box;
  for (auto face = begin; face != end; ++face) box.extend(centroids[*face]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    return centroids[a][axis] < centroids[b][axis];
  });
  Halve(centroids, most, begin, middle, take);
  Halve(centroids, most, middle, end, take);
}

}  // namespace

FaceClusters::FaceClusters(const TriangleMesh& surface, const std::vector<bool>& confident,
                           std::size_t faces_a_cluster) {
  const auto corner = [&](std::uint32_t face, int k) {
    return static_cast<std::size_t>(surface.faces[face][k]);
  };
  std::vector<Eigen::Vector3d> centroids;
  centroids.reserve(surface.faces.size());
  for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
    centroids.push_back((surface.vertices[corner(f, 0)] + surface.vertices[corner(f, 1)] +
                         surface.vertices[corner(f, 2)]) /
                        3);
  }
  Faces order(surface.faces.size());
  std::iota(order.begin(), order.end(), 0U);
  faces.reserve(order.size());
  // Of each vertex of the surface: where it is in `vertices`, if after the cluster's first one.
  std::vector<std::int64_t> place(surface.vertices.size(), -1);
  const auto take = [&](Faces::iterator begin, Faces::iterator end) {
    if (begin == end) return;
    Cluster cluster;
    cluster.first_vertex = static_cast<std::uint32_t>(vertices.size());
    cluster.first_face = static_cast<std::uint32_t>(faces.size());
    Eigen::AlignedBox3d box;
    for (auto f = begin; f != end; ++f) {
      Face face;
      face.is_confident = confident.empty() || confident[*f];
      for (int k = 0; k < 3; ++k) {
        const std::size_t vertex = corner(*f, k);
        if (place[vertex] < static_cast<std::int64_t>(cluster.first_vertex)) {
          place[vertex] = static_cast<std::int64_t>(vertices.size());
          vertices.push_back(surface.vertices[vertex]);
          box.extend(vertices.back());
        }
        face.vertices[static_cast<std::size_t>(k)] =
            static_cast<std::uint32_t>(place[vertex]) - cluster.first_vertex;
      }
      faces.push_back(face);
    }
    cluster.end_vertex = static_cast<std::uint32_t>(vertices.size());
    cluster.end_face = static_cast<std::uint32_t>(faces.size());
    cluster.center = box.center();
    for (std::size_t v = cluster.first_vertex; v < vertices.size(); ++v) {
      cluster.radius_m = std::max(cluster.radius_m, (vertices[v] - cluster.center).norm());
    }
    clusters.push_back(cluster);
  };
  Halve(centroids, faces_a_cluster, order.begin(), order.end(), take);
}

}  // namespace colmap_ext
