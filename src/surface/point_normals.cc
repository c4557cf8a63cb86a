#include "colmap_ext/surface/point_normals.h"

#include <Eigen/Eigenvalues>
#include <limits>

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

Eigen::Vector3d PlaneNormal(const OrientedPoints& points,
                            const std::vector<PointNeighbor>& neighbors) {
  const auto position = [&](const PointNeighbor& neighbor) {
    return points[static_cast<std::size_t>(neighbor.index)].position;
  };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PointNeighbor& neighbor : neighbors) mean += position(neighbor);
  mean /= static_cast<double>(neighbors.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const PointNeighbor& neighbor : neighbors) {
    const Eigen::Vector3d offset = position(neighbor) - mean;
    scatter += offset * offset.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
}

// The centre of the photo that the surface is taken to face.
Eigen::Vector3d NearestViewer(const std::vector<PosedPhoto>& photos,
                              const std::vector<Eigen::Vector3d>& centers,
                              const Eigen::Vector3d& position) {
  const double infinity = std::numeric_limits<double>::infinity();
  double nearest_seeing = infinity, nearest = infinity;
  Eigen::Vector3d seeing = centers.front(), any = centers.front();
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const double distance = (centers[i] - position).norm();
    if (distance < nearest) {
      nearest = distance;
      any = centers[i];
    }
    if (distance >= nearest_seeing) continue;
    const Eigen::Vector3d in_cam = photos[i].cam_from_world * position;
    if (in_cam.z() <= 0 || !photos[i].camera.Contains(photos[i].camera.Project(in_cam))) continue;
    nearest_seeing = distance;
    seeing = centers[i];
  }
  return nearest_seeing < infinity ? seeing : any;
}

}  // namespace

void EstimateNormals(const std::vector<PosedPhoto>& photos, int num_neighbors,
                     OrientedPoints* points) {
  if (num_neighbors < 3) throw Error("normals need at least 3 neighbours");
  const auto count = static_cast<std::size_t>(num_neighbors);
  if (points->size() < count) {
    throw Error("normals need at least " + std::to_string(num_neighbors) + " points, there are " +
                std::to_string(points->size()));
  }
  if (photos.empty()) throw Error("normals need photos that say which side is seen");
  std::vector<Eigen::Vector3d> positions, centers;
  for (const OrientedPoint& point : *points) positions.push_back(point.position);
  for (const PosedPhoto& photo : photos) centers.push_back(CameraCenter(photo.cam_from_world));
  const PointIndex index(positions);
  ParallelFor(points->size(), [&](std::size_t i) {
    const Eigen::Vector3d normal = PlaneNormal(*points, index.NearestOf(positions[i], count));
    const Eigen::Vector3d to_viewer = NearestViewer(photos, centers, positions[i]) - positions[i];
    (*points)[i].normal = normal.dot(to_viewer) < 0 ? Eigen::Vector3d(-normal) : normal;
  });
}

}  // namespace colmap_ext
