#include "surface/open3d_bridge.h"

// Open3D's headers are not written for -Wconversion.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <open3d/geometry/KDTreeFlann.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#pragma GCC diagnostic pop

#include <cmath>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <tuple>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Kazhdan's code, which Open3D carries, writes remarks for its author ("bad average roots") to
// std::cerr and has no switch for that. While this object lives they go nowhere; our own messages
// do not pass through std::cerr.
class QuietCerr {
 public:
  QuietCerr() : buffer_(std::cerr.rdbuf(nullptr)) {}
  ~QuietCerr() { std::cerr.rdbuf(buffer_); }  // clears the error state too
  QuietCerr(const QuietCerr&) = delete;
  QuietCerr& operator=(const QuietCerr&) = delete;

 private:
  std::streambuf* buffer_;
};

}  // namespace

PoissonMesh RunPoisson(const ThinnedCloud& cloud, int depth, double cell_m) {
  BoundingBox bounds;
  for (const Eigen::Vector3d& position : cloud.positions) bounds.extend(position);
  // Open3D computes in float32: coordinates are kept small.
  const Eigen::Vector3d center = bounds.center();
  open3d::geometry::PointCloud points;
  points.points_.reserve(cloud.positions.size());
  for (const Eigen::Vector3d& position : cloud.positions) {
    points.points_.push_back(position - center);
  }
  points.normals_ = cloud.normals;
  points.colors_ = cloud.colors;

  // Open3D's root cube is `scale` times the extent; ours must be a whole number of cells.
  const double scale = std::ldexp(cell_m, depth) / bounds.sizes().maxCoeff();
  // Linear fitting places vertices as well as the quadratic one here (measured on noisy spheres).
  // More threads than one give other results in each run, and are slower.
  constexpr bool kLinearFit = true;
  constexpr int kThreads = 1;
  std::shared_ptr<open3d::geometry::TriangleMesh> mesh;
  try {
    const QuietCerr quiet;
    mesh = std::get<0>(open3d::geometry::TriangleMesh::CreateFromPointCloudPoisson(
        points, static_cast<std::size_t>(depth), 0.0F, static_cast<float>(scale), kLinearFit,
        kThreads));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::system_error&) {
    throw;  // no memory for a thread
  } catch (const std::exception& error) {
    throw Error(std::string("Poisson surface reconstruction failed: ") + error.what());
  }

  PoissonMesh result;
  result.mesh.vertices.reserve(mesh->vertices_.size());
  for (const Eigen::Vector3d& vertex : mesh->vertices_) {
    if (!vertex.allFinite())
      throw Error("Poisson surface reconstruction gave a vertex at infinity");
    result.mesh.vertices.push_back(vertex + center);
  }
  result.mesh.faces = mesh->triangles_;
  result.colors = mesh->vertex_colors_;
  result.colors.resize(result.mesh.vertices.size(), Eigen::Vector3d::Constant(0.5));
  for (Eigen::Vector3d& color : result.colors) color = color.cwiseMax(0.0).cwiseMin(1.0);
  return result;
}

struct NeighborSearch::Impl {
  Eigen::MatrixXd points;  // 3 x n; the tree keeps a reference to it
  open3d::geometry::KDTreeFlann tree;
};

NeighborSearch::NeighborSearch(const std::vector<Eigen::Vector3d>& points)
    : impl_(std::make_unique<Impl>()) {
  if (points.empty()) throw Error("no points to search");
  impl_->points = Eigen::Map<const Eigen::MatrixXd>(points.front().data(), 3,
                                                    static_cast<Eigen::Index>(points.size()));
  impl_->tree.SetMatrixData(impl_->points);
}

NeighborSearch::~NeighborSearch() = default;

std::vector<Neighbor> NeighborSearch::Nearest(const Eigen::Vector3d& point, int count) const {
  std::vector<int> indices;
  std::vector<double> squared_distances;
  const int found = impl_->tree.SearchKNN(point, count, indices, squared_distances);
  std::vector<Neighbor> neighbors;
  neighbors.reserve(static_cast<std::size_t>(found));
  for (std::size_t i = 0; i < static_cast<std::size_t>(found); ++i) {
    neighbors.push_back({static_cast<std::size_t>(indices[i]), squared_distances[i]});
  }
  return neighbors;
}

}  // namespace colmap_ext
