#include "timing.h"

#include <algorithm>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {
namespace {

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                   values.end());
  return values[rank];
}

// Vertices in the region, by their distance to the truth, and the truth by its distance to the
// mesh.
void AddQuality(const std::string& name, const TriangleMesh& mesh, const Site& site,
                BenchReport* report) {
  std::vector<Eigen::Vector3d> vertices;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (site.region.contains(vertex)) vertices.push_back(vertex);
  }
  const std::vector<double> errors = DistancesTo(site.truth, vertices);
  report->Add(name + ": vertices in the region", static_cast<double>(vertices.size()), "");
  report->Add(name + ": median error of its vertices", 1000 * Quantile(errors, 0.5), "mm");
  report->Add(name + ": 90th percentile", 1000 * Quantile(errors, 0.9), "mm");
  std::vector<Eigen::Vector3d> samples;
  for (const SurfaceSample& sample : SampleUniformly(site.truth, 200000, 1)) {
    if (site.region.contains(sample.position)) samples.push_back(sample.position);
  }
  const std::vector<double> gaps = DistancesTo(mesh, samples);
  report->Add(name + ": median distance of the truth to it", 1000 * Quantile(gaps, 0.5), "mm");
  report->Add(name + ": 90th percentile of that", 1000 * Quantile(gaps, 0.9), "mm");
}

ChildProcessResult RunPoissonMesher(const std::filesystem::path& points,
                                    const std::filesystem::path& mesh, int depth,
                                    const JobControl& job) {
  ChildProcessOptions options;
  // COLMAP's default trim of 10 gives an empty mesh at these depths.
  options.arguments = {"colmap",
                       "poisson_mesher",
                       "--input_path",
                       points.string(),
                       "--output_path",
                       mesh.string(),
                       "--PoissonMeshing.depth",
                       std::to_string(depth),
                       "--PoissonMeshing.trim",
                       "5",
                       "--PoissonMeshing.color",
                       "0"};
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  options.log_path = mesh.string() + ".log";
  const ChildProcessResult result = RunChildProcess(options, job);
  if (result.exit_code != 0)
    throw Error("colmap poisson_mesher failed; see " + options.log_path.string());
  return result;
}

}  // namespace

void MeasureTimes(const std::string& name, const Site& site, const FlightModels& models,
                  const CoverageOptions& options, BenchReport* report, const JobControl& job) {
  OrientedPoints points = ReadOrientedPoints(models.fused);
  std::erase_if(points, [&](const OrientedPoint& p) { return !site.region.contains(p.position); });
  const StageTimer surface_timer;
  const Surface surface = ReconstructSurface(points, {site.region}, SurfaceOptions(), job);
  const StageCost surface_cost = surface_timer.Stop();
  report->Add(name + ": points", static_cast<double>(points.size()), "");
  report->Add(name + ": surface, wall", surface_cost.wall_s, "s", AtMost(6));
  report->Add(name + ": surface, CPU", surface_cost.cpu_s, "CPU s");
  AddQuality(name + ", our surface", surface.mesh, site, report);

  const std::filesystem::path folder = models.surface.parent_path() / "poisson_mesher";
  std::filesystem::create_directories(folder);
  WriteOrientedPoints(points, folder / "points.ply");
  for (const int depth : {7, 8}) {
    const std::filesystem::path mesh = folder / ("depth_" + std::to_string(depth) + ".ply");
    const ChildProcessResult run = RunPoissonMesher(folder / "points.ply", mesh, depth, job);
    const std::string label = name + ", poisson_mesher depth " + std::to_string(depth);
    report->Add(label + ": wall", run.wall_s, "s");
    report->Add(label + ": CPU", run.cpu_s, "CPU s");
    report->Add(label + ": our CPU by its", surface_cost.cpu_s / run.cpu_s, "ratio");
    AddQuality(label, ReadMesh(mesh), site, report);
  }

  const PhotoSet photos = LoadPhotoSet(ReadReconstruction(models.sparse), "", false);
  const StageTimer coverage_timer;
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, {site.region}, options, job);
  const StageCost coverage_cost = coverage_timer.Stop();
  report->Add(name + ": photos", static_cast<double>(photos.photos.size()), "");
  report->Add(name + ": iso-points", static_cast<double>(map.points.size()), "");
  report->Add(name + ": coverage, wall", coverage_cost.wall_s, "s", AtMost(0.5));
  report->Add(name + ": coverage, CPU", coverage_cost.cpu_s, "CPU s");
}

}  // namespace colmap_ext
