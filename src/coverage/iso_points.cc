#include "colmap_ext/coverage/iso_points.h"

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

// Linear interpolation of a vertex property at a point of a face, by the areas of the parts.
double Interpolate(const TriangleMesh& mesh, const std::vector<double>& value_of_vertex,
                   const SurfaceSample& sample) {
  const Eigen::Vector3i& face = mesh.faces[static_cast<std::size_t>(sample.face)];
  double weighted = 0, total = 0;
  for (int k = 0; k < 3; ++k) {
    const auto vertex = static_cast<std::size_t>(face[k]);
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(face[(k + 1) % 3])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(face[(k + 2) % 3])];
    const double part = (b - sample.position).cross(c - sample.position).norm();
    weighted += part * value_of_vertex[vertex];
    total += part;
  }
  return weighted / total;  // > 0: degenerate faces get no samples
}

}  // namespace

IsoPoints SampleIsoPoints(const Surface& surface, double spacing_m, std::uint64_t seed) {
  const TriangleMesh& mesh = surface.mesh;
  if (!surface.sample_spacing_m.empty() &&
      surface.sample_spacing_m.size() != mesh.vertices.size()) {
    throw Error("the surface has " + std::to_string(mesh.vertices.size()) + " vertices but " +
                std::to_string(surface.sample_spacing_m.size()) + " values of sample_spacing_m");
  }
  double area = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) area += FaceArea(mesh, f);
  if (!(area > 0) || !std::isfinite(area)) {
    throw Error("the surface has no faces with an area; coverage needs a mesh of triangles");
  }

  IsoPoints iso;
  iso.spacing_m = spacing_m > 0 ? spacing_m : AutomaticSpacing(area);
  const double no_support = BoundsOf(mesh).diagonal().norm();
  for (const SurfaceSample& sample : SamplePoissonDisk(mesh, iso.spacing_m, seed)) {
    IsoPoint point;
    point.position = sample.position;
    point.normal = sample.normal;
    point.sample_spacing_m = surface.sample_spacing_m.empty()
                                 ? no_support
                                 : Interpolate(mesh, surface.sample_spacing_m, sample);
    iso.points.push_back(point);
  }
  iso.disk_area_m2 = area / static_cast<double>(iso.points.size());
  return iso;
}

}  // namespace colmap_ext
