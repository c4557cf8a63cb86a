#include "speed.h"

#include <algorithm>
#include <limits>

#if COLMAP_EXT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "colmap_ext/geom/embree_scene.h"
#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/photo_scale.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {
namespace {

struct Situation {
  CoverageMap coverage;
  TriangleMesh surface;
  PhotoSet photos;
};

Situation AfterFirstFlight(const TrueSite& site) {
  Situation situation;
  situation.surface = site.mesh();
  situation.photos.photos = site.FirstFlight();
  CoverageCounter counter = site.NewCounter();
  for (const PosedPhoto& photo : situation.photos.photos) counter.Add(photo);
  situation.coverage = counter.map();
  return situation;
}

Situation OfSession(const std::filesystem::path& path, int max_width_px) {
  const Workspace workspace(path);
  const std::optional<int> latest = workspace.LatestIteration();
  if (!latest) throw Error(path.string() + ": has no iteration");
  const IterationFiles files{workspace.iteration(*latest)};
  Situation situation;
  situation.surface = ReadMesh(files.surface_ply());
  situation.coverage = ReadCoverageMap(files.coverage_ply());
  situation.photos = LoadPhotoSet(ReadReconstruction(files.sparse()), "", false);
  DownscalePhotos(max_width_px, &situation.photos);
  return situation;
}

struct Timed {
  StageCost best;  // of several runs, by wall time
  ViewPlanResult plan;
};

Timed TimePlan(const Situation& situation, const NextBestViewOptions& options,
               const PathOptions& path_options, int repetitions) {
  const std::vector<PosedPhoto>& photos = situation.photos.photos;
  ViewPlanInput input{situation.coverage, situation.surface, photos};
  input.camera = photos.front().camera;
  input.points = &situation.photos.points;
  input.start = CameraCenter(photos.back().cam_from_world);
  input.may_fly = FlyablePositions(situation.surface, photos, *input.start, path_options);
  Timed timed;
  timed.best.wall_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const StageTimer timer;
    timed.plan = PlanNextViews(input, options, JobControl());
    const StageCost cost = timer.Stop();
    if (cost.wall_s < timed.best.wall_s) timed.best = cost;
  }
  return timed;
}

void AddTimes(const std::string& name, const Timed& timed, double goal_s, BenchReport* report) {
  report->Add(name + ": wall time", timed.best.wall_s, "s", AtMost(goal_s));
  report->Add(name + ": processor time", timed.best.cpu_s, "CPU s");
  report->Add(name + ": views", static_cast<double>(timed.plan.views.size()), "");
  report->Add(name + ": tour", timed.plan.tour_length_m, "m");
}

// What it takes to know where the vehicle can be, before a plan.
void AddSpaceCost(const std::string& name, const Situation& situation, const PathOptions& options,
                  int repetitions, BenchReport* report) {
  const std::vector<PosedPhoto>& photos = situation.photos.photos;
  const Eigen::Vector3d start = CameraCenter(photos.back().cam_from_world);
  double best_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const StageTimer timer;
    KnownSpace({situation.surface}, photos, start, options);
    best_s = std::min(best_s, timer.Stop().cpu_s);
  }
  report->Add(name + ": known space of " + std::to_string(photos.size()) + " photos", best_s,
              "CPU s", AtMost(0.3));
}

struct Segment {
  Eigen::Vector3d from, to, normal;
};

// From positions of the pool's kind to the points that face them.
std::vector<Segment> PlannersRays(const TrueSite& site) {
  const Situation situation = AfterFirstFlight(site);
  std::vector<Segment> segments;
  constexpr std::size_t kMostRays = 2000000;
  for (const PosedPhoto& photo : situation.photos.photos) {
    for (const IsoPoint& point : situation.coverage.points) {
      const Eigen::Vector3d from = CameraCenter(photo.cam_from_world);
      if ((from - point.position).dot(point.normal) <= 0) continue;
      segments.push_back({from, point.position, point.normal});
      if (segments.size() == kMostRays) return segments;
    }
  }
  return segments;
}

// Embree's own any-hit query, one ray at a time, as RayScene sets the scene up.
double RawRaysPerSecond(const TriangleMesh& mesh, const std::vector<Segment>& segments,
                        double epsilon_m) {
  const EmbreeScene scene(mesh);
  std::vector<RTCRay> rays;
  for (const Segment& segment : segments) {
    const Eigen::Vector3f from = segment.from.cast<float>();
    const Eigen::Vector3d offset = segment.to + epsilon_m * segment.normal - segment.from;
    const Eigen::Vector3f direction = offset.normalized().cast<float>();
    RTCRay ray{};
    ray.org_x = from.x(), ray.org_y = from.y(), ray.org_z = from.z();
    ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
    ray.tnear = static_cast<float>(epsilon_m);
    ray.tfar = static_cast<float>(offset.norm() - epsilon_m);
    ray.mask = ~0U;
    rays.push_back(ray);
  }
  const StageTimer timer;
  for (RTCRay& ray : rays) {
#if COLMAP_EXT_EMBREE_MAJOR >= 4
    rtcOccluded1(scene.get(), &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene.get(), &context, &ray);
#endif
  }
  return static_cast<double>(rays.size()) / timer.Stop().cpu_s;
}

}  // namespace

void MeasureSpeed(const TrueSite& site, const std::filesystem::path& workspace, int repetitions,
                  BenchReport* report) {
  const StageOptions& stages = site.options();
  const Situation situation = workspace.empty()
                                  ? AfterFirstFlight(site)
                                  : OfSession(workspace, stages.session.max_image_size_px);
  const std::string where = site.scene() + (workspace.empty() ? "" : " (session)");
  report->Add(where + ": faces of the surface", static_cast<double>(situation.surface.faces.size()),
              "");
  report->Add(where + ": uncovered iso-points",
              static_cast<double>(situation.coverage.Count(CoverageClass::kUncovered)), "");
  AddSpaceCost(where, situation, stages.path, repetitions, report);
  NextBestViewOptions options = stages.nbv;
  options.visibility = stages.coverage.visibility;
  options.strategy = "plane_sweep";
  AddTimes(where + ", plane_sweep", TimePlan(situation, options, stages.path, repetitions), 1.5,
           report);
  NextBestViewOptions paper = options;
  paper.paper_only = true;
  paper.num_views = 5;
  AddTimes(where + ", plane_sweep, the paper's only",
           TimePlan(situation, paper, stages.path, repetitions), 1.5, report);
  options.strategy = "submodular";
  AddTimes(where + ", submodular, " + std::to_string(options.num_views) + " views",
           TimePlan(situation, options, stages.path, repetitions), 0.75, report);
  options.num_views = 120;
  options.min_relative_gain = 0;
  AddTimes(where + ", submodular, up to 120 views",
           TimePlan(situation, options, stages.path, repetitions), 0.75, report);
  // A wish for finer photos, so that there is work for all 120.
  Situation finer = situation;
  for (IsoPoint& point : finer.coverage.points) {
    if (point.coverage != CoverageClass::kIgnored) point.coverage = CoverageClass::kUncovered;
  }
  finer.coverage.min_projection_ratio *= 4;
  AddTimes(where + ", submodular, up to 120 views, half the ground sampling distance",
           TimePlan(finer, options, stages.path, repetitions), 0.75, report);
}

void MeasureRays(const TrueSite& site, BenchReport* report) {
  const VisibilityEngine engine(site.mesh(), site.options().coverage.visibility);
  const std::vector<Segment> segments = PlannersRays(site);
  const StageTimer timer;
  std::size_t num_seen = 0;
  for (const Segment& segment : segments) {
    if (engine.IsUnoccluded(segment.from, segment.to, segment.normal)) ++num_seen;
  }
  const double ours = static_cast<double>(segments.size()) / timer.Stop().cpu_s;
  const double raw = RawRaysPerSecond(site.mesh(), segments, engine.epsilon_m());
  report->Add(site.scene() + ": rays that meet nothing",
              100.0 * static_cast<double>(num_seen) / static_cast<double>(segments.size()), "%");
  report->Add(site.scene() + ": rays a CPU second, planner's test", 1e-6 * ours, "million");
  report->Add(site.scene() + ": rays a CPU second, Embree directly", 1e-6 * raw, "million");
  report->Add(site.scene() + ": planner's part of Embree's rate", ours / raw, "ratio");
}

}  // namespace colmap_ext
