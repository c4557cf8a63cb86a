#include "samples.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iterator>

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/util/parallel.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

// Enough to average out a scanner's noise, few enough to stay on one face.
constexpr std::size_t kNormalNeighbors = 16;

std::vector<SurfaceSample> CloudSamplesInBox(const std::vector<Eigen::Vector3d>& points,
                                             const BoundingBox& box, double spacing_m,
                                             std::uint64_t seed) {
  std::vector<Eigen::Vector3d> inside;
  std::copy_if(points.begin(), points.end(), std::back_inserter(inside),
               [&](const Eigen::Vector3d& point) { return box.contains(point); });
  std::vector<SurfaceSample> samples;
  for (const std::size_t i : ThinPoints(inside, spacing_m, seed)) {
    samples.push_back({inside[i], Eigen::Vector3d::Zero(), -1});
  }
  return samples;
}

Eigen::Vector3d PlaneNormal(const std::vector<Eigen::Vector3d>& points, const PointIndex& index,
                            const Eigen::Vector3d& at) {
  const std::vector<PointNeighbor> neighbors = index.NearestOf(at, kNormalNeighbors);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PointNeighbor& n : neighbors) mean += points[static_cast<std::size_t>(n.index)];
  mean /= static_cast<double>(neighbors.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PointNeighbor& n : neighbors) {
    const Eigen::Vector3d offset = points[static_cast<std::size_t>(n.index)] - mean;
    covariance += offset * offset.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
}

}  // namespace

std::vector<SurfaceSample> SamplesInBox(const TriangleMesh& mesh, const BoundingBox& box,
                                        double spacing_m, std::uint64_t seed) {
  if (mesh.faces.empty()) return CloudSamplesInBox(mesh.vertices, box, spacing_m, seed);
  std::vector<bool> touches(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    BoundingBox face_box;
    for (int k = 0; k < 3; ++k) {
      face_box.extend(mesh.vertices[static_cast<std::size_t>(mesh.faces[i][k])]);
    }
    touches[i] = box.intersects(face_box);
  }
  std::vector<SurfaceSample> samples = SamplePoissonDisk(mesh, spacing_m, seed, touches);
  std::erase_if(samples, [&](const SurfaceSample& s) { return !box.contains(s.position); });
  return samples;
}

std::vector<SurfaceSample> SamplesWithNormals(const TriangleMesh& mesh, std::size_t count,
                                              std::uint64_t seed) {
  if (!mesh.faces.empty()) return SampleUniformly(mesh, count, seed);
  std::vector<std::size_t> order = RandomOrder(mesh.vertices.size(), seed);
  order.resize(std::min(count, order.size()));
  const PointIndex index(mesh.vertices);
  std::vector<SurfaceSample> samples(order.size());
  ParallelFor(order.size(), [&](std::size_t i) {
    const Eigen::Vector3d& position = mesh.vertices[order[i]];
    samples[i] = {position, PlaneNormal(mesh.vertices, index, position), -1};
  });
  return samples;
}

}  // namespace colmap_ext
