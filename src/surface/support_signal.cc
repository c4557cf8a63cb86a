#include "surface/support_signal.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "surface/open3d_bridge.h"

namespace colmap_ext {
namespace {

constexpr int kNumNeighbors = 24;
constexpr double kMinCosNormals = 0.5;

struct Support {
  double weight = 0;                // summed confidence
  std::vector<PhotoWeight> photos;  // of known photos

  void Add(const PhotoWeight& added) {
    weight += added.weight;
    if (added.photo_index < 0) return;
    for (PhotoWeight& photo : photos) {
      if (photo.photo_index != added.photo_index) continue;
      photo.weight += added.weight;
      return;
    }
    photos.push_back(added);
  }

  double WithoutStrongestPhoto() const {
    double strongest = 0;
    for (const PhotoWeight& photo : photos) strongest = std::max(strongest, photo.weight);
    // A difference of rounding errors is no support.
    const double rest = weight - strongest;
    return rest > 1e-9 * weight ? rest : 0.0;
  }
};

double SpacingOf(double weight, double squared_radius, double max_spacing_m) {
  if (!(weight > 0)) return max_spacing_m;
  return std::min(max_spacing_m, std::sqrt(std::numbers::pi * squared_radius / weight));
}

}  // namespace

SupportSpacing ComputeSupportSpacing(const ThinnedCloud& cloud, const TriangleMesh& mesh,
                                     double max_spacing_m) {
  const NeighborSearch search(cloud.positions);
  const std::vector<Eigen::Vector3d> vertex_normals = VertexNormals(mesh);
  SupportSpacing spacing;
  spacing.all.resize(mesh.vertices.size());
  spacing.independent.resize(mesh.vertices.size());
  const auto compute_vertex = [&](std::size_t vertex) {
    const std::vector<Neighbor> neighbors = search.Nearest(mesh.vertices[vertex], kNumNeighbors);
    Support support;
    double weight_of_all = 0;
    // The furthest neighbour bounds the disk, and is not counted inside it: without that the
    // density of k points would come out k / (k - 1) times too high.
    for (std::size_t i = 0; i + 1 < neighbors.size(); ++i) {
      const std::size_t point = neighbors[i].index;
      const bool agrees = cloud.normals[point].dot(vertex_normals[vertex]) >= kMinCosNormals;
      for (std::size_t k = cloud.photo_begin[point]; k < cloud.photo_begin[point + 1]; ++k) {
        weight_of_all += cloud.photo_weights[k].weight;
        if (agrees) support.Add(cloud.photo_weights[k]);
      }
    }
    const double squared_radius = neighbors.back().squared_distance;
    spacing.all[vertex] = SpacingOf(weight_of_all, squared_radius, max_spacing_m);
    spacing.independent[vertex] =
        SpacingOf(support.WithoutStrongestPhoto(), squared_radius, max_spacing_m);
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.vertices.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) compute_vertex(i);
                    });
  return spacing;
}

}  // namespace colmap_ext
