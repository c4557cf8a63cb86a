#include "nearest.h"

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

std::variant<ClosestPointIndex, PointIndex> MakeIndex(const TriangleMesh& mesh, bool to_vertices) {
  if (to_vertices || mesh.faces.empty()) return PointIndex(mesh.vertices);
  return ClosestPointIndex(mesh);
}

}  // namespace

NearestFinder::NearestFinder(const TriangleMesh& mesh, bool to_vertices)
    : index_(MakeIndex(mesh, to_vertices)) {
  if (std::holds_alternative<PointIndex>(index_)) vertices_ = mesh.vertices;
}

std::optional<NearestPoint> NearestFinder::Find(const Eigen::Vector3d& query,
                                                double max_distance) const {
  if (const auto* surface = std::get_if<ClosestPointIndex>(&index_)) {
    const auto found = surface->Find(query, max_distance);
    if (!found) return std::nullopt;
    return NearestPoint{found->position, found->distance, found->face};
  }
  const auto found = std::get<PointIndex>(index_).Nearest(query, max_distance);
  if (!found) return std::nullopt;
  return NearestPoint{vertices_[static_cast<std::size_t>(found->index)], found->distance};
}

std::vector<double> NearestFinder::Distances(const std::vector<Eigen::Vector3d>& points) const {
  std::vector<double> distances(points.size());
  ParallelFor(points.size(), [&](std::size_t i) { distances[i] = Find(points[i])->distance; });
  return distances;
}

}  // namespace colmap_ext
