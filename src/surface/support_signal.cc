#include "surface/support_signal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "colmap_ext/util/parallel.h"
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

// Of points along a normal.
class Scatter {
 public:
  void Add(double weight, double offset_m, double squared_scatter_m2) {
    weight_ += weight;
    squares_ += weight * (offset_m * offset_m + squared_scatter_m2);
  }
  double Rms(double max_m) const {
    return weight_ > 0 ? std::min(max_m, std::sqrt(squares_ / weight_)) : max_m;
  }

 private:
  double weight_ = 0, squares_ = 0;
};

double SpacingOf(double weight, double squared_radius, double max_spacing_m) {
  if (!(weight > 0)) return max_spacing_m;
  return std::min(max_spacing_m, std::sqrt(std::numbers::pi * squared_radius / weight));
}

}  // namespace

SupportSignal ComputeSupportSignal(const ThinnedCloud& cloud, const TriangleMesh& mesh,
                                   double max_spacing_m) {
  const NeighborSearch search(cloud.positions);
  const std::vector<Eigen::Vector3d> vertex_normals = VertexNormals(mesh);
  SupportSignal signal;
  signal.spacing.resize(mesh.vertices.size());
  signal.independent_spacing.resize(mesh.vertices.size());
  signal.scatter.resize(mesh.vertices.size());
  const auto compute_vertex = [&](std::size_t vertex) {
    const std::vector<Neighbor> neighbors = search.Nearest(mesh.vertices[vertex], kNumNeighbors);
    const Eigen::Vector3d& normal = vertex_normals[vertex];
    Support support;
    Scatter scatter;
    double weight_of_all = 0;
    // The furthest neighbour bounds the disk, and is not counted inside it: without that the
    // density of k points would come out k / (k - 1) times too high.
    for (std::size_t i = 0; i + 1 < neighbors.size(); ++i) {
      const std::size_t point = neighbors[i].index;
      const bool agrees = cloud.normals[point].dot(normal) >= kMinCosNormals;
      for (std::size_t k = cloud.photo_begin[point]; k < cloud.photo_begin[point + 1]; ++k) {
        weight_of_all += cloud.photo_weights[k].weight;
        if (!agrees) continue;
        support.Add(cloud.photo_weights[k]);
        const double offset = normal.dot(cloud.positions[point] - mesh.vertices[vertex]);
        scatter.Add(cloud.photo_weights[k].weight, offset, cloud.squared_scatter[point]);
      }
    }
    const double squared_radius = neighbors.back().squared_distance;
    signal.spacing[vertex] = SpacingOf(weight_of_all, squared_radius, max_spacing_m);
    signal.independent_spacing[vertex] =
        SpacingOf(support.WithoutStrongestPhoto(), squared_radius, max_spacing_m);
    signal.scatter[vertex] = scatter.Rms(max_spacing_m);
  };
  ParallelFor(mesh.vertices.size(), compute_vertex);
  return signal;
}

}  // namespace colmap_ext
