#include "colmap_ext/coverage/iso_points.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// A maximal Poisson-disk sampling of radius r has about 0.7 / r² points an area.
double AutomaticSpacing(double area_m2) {
  constexpr double kWantedPoints = 7500;
  return std::sqrt(0.7 * area_m2 / kWantedPoints);
}

// Weights of the corners of its face at a sample (barycentric coordinates), by the areas of the
// parts.
Eigen::Vector3d CornerWeights(const TriangleMesh& mesh, const SurfaceSample& sample) {
  const Eigen::Vector3i& face = mesh.faces[static_cast<std::size_t>(sample.face)];
  Eigen::Vector3d weights;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(face[(k + 1) % 3])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(face[(k + 2) % 3])];
    weights[k] = (b - sample.position).cross(c - sample.position).norm();
  }
  return weights / weights.sum();  // > 0: degenerate faces get no samples
}

double LongestEdge(const TriangleMesh& mesh, const Eigen::Vector3i& face) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, (mesh.vertices[static_cast<std::size_t>(face[k])] -
                                 mesh.vertices[static_cast<std::size_t>(face[(k + 1) % 3])])
                                    .norm());
  }
  return longest;
}

// An iso-point stands for a disk. On faces much smaller than the disk the normals of the vertices,
// means over the faces around, are nearer to the disk's normal than that of one rough little face;
// larger faces (a mesh drawn by hand) are what the disk lies on.
Eigen::Vector3d DiskNormal(const TriangleMesh& mesh,
                           const std::vector<Eigen::Vector3d>& vertex_normals,
                           const SurfaceSample& sample, const Eigen::Vector3d& weights,
                           double spacing_m) {
  const Eigen::Vector3i& face = mesh.faces[static_cast<std::size_t>(sample.face)];
  if (LongestEdge(mesh, face) > 0.75 * spacing_m) return sample.normal;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    normal += weights[k] * vertex_normals[static_cast<std::size_t>(face[k])];
  }
  constexpr double kMinLength = 0.3;  // less: the faces around contradict each other
  return normal.norm() > kMinLength ? normal.normalized() : sample.normal;
}

void RequireOneAVertex(const std::string& name, const std::vector<double>& values,
                       const TriangleMesh& mesh) {
  if (values.empty() || values.size() == mesh.vertices.size()) return;
  throw Error("the surface has " + std::to_string(mesh.vertices.size()) + " vertices but " +
              std::to_string(values.size()) + " values of " + name);
}

// On a face, from the values of the vertices; `unknown` without them.
double Interpolated(const std::vector<double>& values, const Eigen::Vector3i& face,
                    const Eigen::Vector3d& weights, double unknown) {
  if (values.empty()) return unknown;
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += weights[k] * values[static_cast<std::size_t>(face[k])];
  return sum;
}

}  // namespace

IsoPoints SampleIsoPoints(const Surface& surface, double spacing_m, std::uint64_t seed) {
  const TriangleMesh& mesh = surface.mesh;
  RequireOneAVertex("sample_spacing_m", surface.sample_spacing_m, mesh);
  RequireOneAVertex("scatter_m", surface.scatter_m, mesh);
  double area = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) area += FaceArea(mesh, f);
  if (!(area > 0) || !std::isfinite(area)) {
    throw Error("the surface has no faces with an area; coverage needs a mesh of triangles");
  }

  IsoPoints iso;
  iso.spacing_m = spacing_m > 0 ? spacing_m : AutomaticSpacing(area);
  const double no_support = BoundsOf(mesh).diagonal().norm();
  const std::vector<Eigen::Vector3d> vertex_normals = VertexNormals(mesh);
  for (const SurfaceSample& sample : SamplePoissonDisk(mesh, iso.spacing_m, seed)) {
    IsoPoint point;
    point.position = sample.position;
    const Eigen::Vector3d weights = CornerWeights(mesh, sample);
    point.normal = DiskNormal(mesh, vertex_normals, sample, weights, iso.spacing_m);
    const Eigen::Vector3i& face = mesh.faces[static_cast<std::size_t>(sample.face)];
    point.sample_spacing_m = Interpolated(surface.sample_spacing_m, face, weights, no_support);
    point.scatter_m = Interpolated(surface.scatter_m, face, weights, 0);
    iso.points.push_back(point);
  }
  iso.disk_area_m2 = area / static_cast<double>(iso.points.size());
  return iso;
}

}  // namespace colmap_ext
