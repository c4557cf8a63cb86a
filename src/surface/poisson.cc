#include "colmap_ext/surface/poisson.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"
#include "surface/mesh_cleaning.h"
#include "surface/open3d_bridge.h"
#include "surface/support_signal.h"
#include "surface/thinned_cloud.h"

namespace colmap_ext {
namespace {

constexpr char kStage[] = "surface";
constexpr std::size_t kMinPoints = 50;
constexpr int kMinDepth = 4;
constexpr int kMaxDepth = 11;
// Part of the extent by which the octree's root is larger, so that the surface can close.
constexpr double kRootScale = 1.1;

struct Grid {
  int depth = 0;
  double cell_m = 0;
};

// A surface of area A on cells of edge h has about 1.45 A / h² vertices (measured on spheres).
double AutomaticResolution(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                           const SurfaceOptions& options, double extent_m) {
  const double area = EstimateArea(points, selected, extent_m / 128);
  const double affordable = std::sqrt(1.45 * area / options.max_vertices);
  return std::max(affordable, 2e-3 * options.ground_sampling_distance_mm);
}

Grid ChooseGrid(const OrientedPoints& points, const std::vector<std::size_t>& selected,
                const SurfaceOptions& options) {
  BoundingBox bounds;
  for (const std::size_t i : selected) bounds.extend(points[i].position);
  const double extent = bounds.sizes().maxCoeff();
  if (!(extent > 0)) throw Error("all points of the fused cloud are at the same place");
  Grid grid;
  if (options.depth > 0) {
    grid.depth = options.depth;
    grid.cell_m = std::ldexp(kRootScale * extent, -grid.depth);
    return grid;
  }
  grid.cell_m = options.resolution_m > 0 ? options.resolution_m
                                         : AutomaticResolution(points, selected, options, extent);
  const double cells = kRootScale * extent / grid.cell_m;
  grid.depth = std::max(kMinDepth, static_cast<int>(std::ceil(std::log2(cells))));
  if (grid.depth > kMaxDepth) {
    grid.depth = kMaxDepth;
    grid.cell_m = std::ldexp(kRootScale * extent, -grid.depth);
  }
  return grid;
}

BoundingBox Widened(const RegionOfInterest& region, double margin_ratio) {
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(margin_ratio * region.box.diagonal().norm());
  return {region.box.min() - margin, region.box.max() + margin};
}

std::vector<bool> SupportedFaces(const TriangleMesh& mesh, const std::vector<double>& spacing,
                                 const BoundingBox& box, double max_spacing_m) {
  std::vector<bool> keep(mesh.faces.size(), true);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(mesh.faces[f][k]);
      if (spacing[vertex] > max_spacing_m || !box.contains(mesh.vertices[vertex])) keep[f] = false;
    }
    if (!(FaceArea(mesh, f) > 0)) keep[f] = false;
  }
  return keep;
}

// Cuts the raw surface at the box and where nothing supports it, and drops crumbs.
Surface Clean(PoissonMesh raw, SupportSignal signal, const BoundingBox& box, double trim_m,
              const SurfaceOptions& options) {
  const std::vector<bool> supported = SupportedFaces(raw.mesh, signal.spacing, box, trim_m);
  Surface surface{std::move(raw.mesh), std::move(signal.independent_spacing),
                  std::move(signal.scatter), std::move(raw.colors)};
  surface = KeepFaces(surface, supported);
  const double min_area = options.min_component_area_m2 > 0 ? options.min_component_area_m2
                                                            : 0.002 * TotalArea(surface.mesh);
  return KeepFaces(surface, FacesOfLargePieces(surface.mesh, min_area));
}

std::string Metres(double value) {
  std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 4) + " m";
}

}  // namespace

std::string SurfaceOptions::Check() const {
  if (depth != 0 && (depth < kMinDepth || depth > kMaxDepth)) {
    return "SurfaceReconstructor.depth must be 0 (from the resolution) or 4 to 11";
  }
  if (!(resolution_m >= 0)) return "SurfaceReconstructor.resolution_m must be >= 0 (0: automatic)";
  if (!(ground_sampling_distance_mm >= 0)) {
    return "SurfaceReconstructor.ground_sampling_distance_mm must be >= 0 (0: not known)";
  }
  if (max_vertices < 1000 || max_vertices > 10000000) {
    return "SurfaceReconstructor.max_vertices must be in [1000, 10^7]";
  }
  if (!(trim_spacing_m >= 0)) {
    return "SurfaceReconstructor.trim_spacing_m must be >= 0 (0: automatic)";
  }
  if (!(min_component_area_m2 >= 0)) {
    return "SurfaceReconstructor.min_component_area_m2 must be >= 0 (0: automatic)";
  }
  if (!(crop_margin_ratio >= 0 && crop_margin_ratio <= 1)) {
    return "SurfaceReconstructor.crop_margin_ratio must be in [0, 1]";
  }
  if (!(min_confidence >= 0 && min_confidence <= 1)) {
    return "SurfaceReconstructor.min_confidence must be in [0, 1]";
  }
  return "";
}

void BindOptions(OptionSet& set, SurfaceOptions* options) {
  const std::string section = "SurfaceReconstructor";
  set.Add(section, "depth", &options->depth, "octree depth, 4 to 11; 0: from resolution_m");
  set.Add(section, "resolution_m", &options->resolution_m,
          "edge of the finest cell, metres; 0: two wanted pixels, within max_vertices");
  set.Add(section, "ground_sampling_distance_mm", &options->ground_sampling_distance_mm,
          "wanted resolution on the surface, mm a pixel; 0: not known, max_vertices decides");
  set.Add(section, "max_vertices", &options->max_vertices,
          "vertices that the automatic resolution aims at, at most");
  set.Add(section, "trim_spacing_m", &options->trim_spacing_m,
          "cut faces whose points are further apart than this, metres; 0: 5 % of the region");
  set.Add(section, "min_component_area_m2", &options->min_component_area_m2,
          "drop smaller pieces, square metres; 0: 0.2 % of the surface");
  set.Add(section, "crop_margin_ratio", &options->crop_margin_ratio,
          "keep this much around the region of interest, part of its diagonal, 0 to 1");
  set.Add(section, "min_confidence", &options->min_confidence,
          "leave out points of less confidence, 0 to 1");
}

Surface ReconstructSurface(const OrientedPoints& points, const RegionOfInterest& region,
                           const SurfaceOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  if (region.box.isEmpty()) throw Error("the region of interest is empty");
  constexpr std::size_t kSteps = 4;
  job.Progress(kStage, 0, kSteps);
  const BoundingBox box = Widened(region, options.crop_margin_ratio);
  const std::vector<std::size_t> selected = UsablePoints(points, box, options.min_confidence);
  if (selected.size() < kMinPoints) {
    throw Error("only " + std::to_string(selected.size()) + " of " + std::to_string(points.size()) +
                " points are usable and in the region of interest; a surface needs at least " +
                std::to_string(kMinPoints) + " (photos that overlap more, or a larger region)");
  }

  const Grid grid = ChooseGrid(points, selected, options);
  // Two points a cell edge keep what the octree can resolve.
  const ThinnedCloud cloud = ThinCloud(points, selected, 0.5 * grid.cell_m);
  job.Debug("surface: " + std::to_string(selected.size()) + " points thinned to " +
            std::to_string(cloud.positions.size()) + ", depth " + std::to_string(grid.depth) +
            ", finest cell " + Metres(grid.cell_m));
  job.ThrowIfCancelled();
  job.Progress(kStage, 1, kSteps);

  PoissonMesh raw = RunPoisson(cloud, grid.depth, grid.cell_m);
  job.ThrowIfCancelled();
  job.Progress(kStage, 2, kSteps);

  const double diagonal = region.box.diagonal().norm();
  SupportSignal signal = ComputeSupportSignal(cloud, raw.mesh, box.diagonal().norm());
  job.ThrowIfCancelled();
  job.Progress(kStage, 3, kSteps);

  const double trim = options.trim_spacing_m > 0 ? options.trim_spacing_m : 0.05 * diagonal;
  Surface surface = Clean(std::move(raw), std::move(signal), box, trim, options);
  if (surface.mesh.faces.empty()) {
    throw Error("no surface is left where points are nearer than " + Metres(trim) +
                " to each other; raise --SurfaceReconstructor.trim_spacing_m");
  }
  job.Progress(kStage, kSteps, kSteps);
  return surface;
}

}  // namespace colmap_ext
