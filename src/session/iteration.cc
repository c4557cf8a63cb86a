#include "session/iteration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <utility>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/coverage/region.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/mission/qgc_plan.h"
#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_io.h"
#include "colmap_ext/mvs/stereo_memory_io.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/image_list.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/photo_scale.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/stage_timer.h"
#include "colmap_ext/util/statistics.h"
#include "session/arbitrary_frame.h"
#include "session/open_session.h"
#include "session/pictures.h"
#include "session/take_off_height.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// 1.5 times the median size of a pixel on the surface, over the sparse points, each in its nearest
// photo.
double SiteGroundSamplingDistanceMm(const PhotoSet& photos) {
  std::vector<double> sizes_mm;
  for (const SupportPoint& point : photos.points) {
    double smallest_mm = std::numeric_limits<double>::infinity();
    for (const int index : point.photo_indices) {
      const PosedPhoto& photo = photos.photos[static_cast<std::size_t>(index)];
      const double depth_m = (photo.cam_from_world * point.position).z();
      smallest_mm = std::min(smallest_mm, 1000.0 * depth_m / photo.camera.fx);
    }
    if (std::isfinite(smallest_mm) && smallest_mm > 0) sizes_mm.push_back(smallest_mm);
  }
  if (sizes_mm.empty()) throw Error("the sparse model has no points in front of its photos");
  return 1.5 * MiddleValue(std::move(sizes_mm));
}

// Everything that the stages of one iteration hand to each other.
struct Work {
  IterationFiles files;
  SparseUpdateResult sparse;
  PhotoSet photos;
  SuperpixelStereoResult stereo;
  OrientedPoints points;
  Surface surface;
  CoverageMap coverage;
  ViewPlanResult plan;
  FlightPath path;
  std::map<std::string, StageCost> cost;
  int iteration = 0;
  SessionObserver* observer = nullptr;
};

StageCost Sum(const StageCost& a, const StageCost& b) {
  return {a.wall_s + b.wall_s, a.cpu_s + b.cpu_s, std::max(a.peak_mib, b.peak_mib)};
}

void Record(const std::string& stage, const StageCost& cost, Work* work, const JobControl& job) {
  work->cost[stage] = cost;
  if (work->observer != nullptr) work->observer->OnStage(work->iteration, stage, cost);
  char line[96];
  std::snprintf(line, sizeof line, "  %-12s %6.1f s", stage.c_str(), cost.wall_s);
  job.Info(line);
}

// Runs `stage` and remembers what it cost.
template <typename Stage>
void Timed(const std::string& name, Work* work, const JobControl& job, const Stage& stage) {
  job.ThrowIfCancelled();
  const StageTimer timer;
  stage();
  Record(name, timer.Stop(), work, job);
}

void RunSparse(const IterationContext& context, const SessionState& state, Work* work,
               const JobControl& job) {
  SparseUpdateInput input = context.sparse;
  input.database_path = context.workspace.database();
  input.work_path = context.workspace.logs();
  Reconstruction earlier;
  if (state.iterations_done > 0) {
    const IterationFiles before{context.workspace.iteration(state.iterations_done - 1)};
    earlier = ReadReconstruction(before.sparse());
    input.model = &earlier;
    input.frame = ReadWorldFrame(before.frame_json());
    input.state = ReadSparseState(before.sparse_state_json());
  } else if (!context.initial_model_path.empty()) {
    earlier = ReadReconstruction(context.initial_model_path);
    input.model = &earlier;
  }
  work->sparse = UpdateSparseModel(input, context.options->sparse, job);
  if (!work->sparse.frame.is_metric_enu && state.iterations_done == 0) {
    const double depth_m = TypicalViewingDistance(context.options->coverage, work->sparse.model);
    NormalizeArbitraryFrame(depth_m, &work->sparse.model);
  }
  if (state.iterations_done == 0) {
    // What is there before we plan anything: a person's flight. Photos that register later are its,
    // too.
    std::set<std::string> names(work->sparse.registered.begin(), work->sparse.registered.end());
    names.insert(work->sparse.unregistered.begin(), work->sparse.unregistered.end());
    WriteImageList(names, context.workspace.first_flight_txt());
  }
  WriteReconstructionBinary(work->sparse.model, work->files.sparse());
  WriteGeoregistration(work->sparse, work->files.sparse());
  WriteWorldFrame(work->sparse.frame, work->files.frame_json());
  WriteSparseState(work->sparse.state, work->files.sparse_state_json());
}

void WriteDenseOutput(const Work& work, double min_confidence) {
  WriteViewMeshes(work.photos, work.stereo.views, min_confidence, work.files.meshes());
  WriteDenseWorkspace(work.photos, work.sparse.model, work.stereo.views, work.stereo.neighbors,
                      min_confidence, work.files.dense());
}

// The pixels that this iteration asks for.
void ReadPixels(const IterationContext& context, const StereoUpdate& update, Work* work) {
  const SessionOptions& options = context.options->session;
  std::vector<std::uint8_t> which = update.needs_pixels;
  if (options.dense_output) which.assign(which.size(), 1);
  if (options.pictures && !which.empty()) which.back() = 1;  // the photo that is shown
  LoadPixels(work->sparse.model, context.sparse.image_path.string(), which, &work->photos.photos);
}

void WriteSolved(const StereoUpdate& update, const StereoMemory& memory, const Work& work) {
  std::set<std::string> solved;
  for (std::size_t i = 0; i < update.settled_scale.size(); ++i) {
    if (!update.settled_scale[i]) solved.insert(work.photos.photos[i].name);
  }
  WriteStereoMemory(memory, solved, work.files.stereo_bin());
}

void RunStereo(const IterationContext& context, Work* work, const JobControl& job) {
  const StageOptions& options = *context.options;
  StereoMemory* memory = context.stereo_memory;
  const StageTimer reading_timer;
  work->photos = LoadPhotoSet(work->sparse.model, "", false);
  DownscalePhotos(options.session.max_image_size_px, &work->photos);
  const StereoUpdate update =
      PlanStereoUpdate(work->photos, options.superpixels, options.stereo, *memory);
  ReadPixels(context, update, work);
  const StageCost reading = reading_timer.Stop();
  work->stereo = UpdateSuperpixelStereo(work->photos, options.superpixels, options.stereo, update,
                                        job, memory);
  Record("superpixels", Sum(reading, work->stereo.superpixels), work, job);
  Record("stereo", Sum(work->stereo.stereo, work->stereo.photometric), work, job);
  const StageTimer points_timer;
  work->points = UpdatePoints(work->photos, work->stereo.views, work->stereo.neighbors,
                              options.points, memory);
  WriteOrientedPoints(work->points, work->files.fused_ply());
  WriteSolved(update, *memory, *work);
  if (options.session.dense_output) WriteDenseOutput(*work, options.points.min_confidence);
  Record("fusion", Sum(work->stereo.fusion, points_timer.Stop()), work, job);
}

void RunSurface(const IterationContext& context, SessionState* state, Work* work,
                const JobControl& job) {
  if (!state->region) {
    state->region = DefaultRegion(work->photos, work->sparse.frame, context.options->region);
  }
  work->surface = ReconstructSurface(work->points, *state->region, context.options->surface, job);
  WriteSurface(work->surface, work->files.surface_ply());
}

void RunCoverage(const IterationContext& context, const SessionState& state, Work* work,
                 const JobControl& job) {
  const CoverageOptions& options = context.options->coverage;
  work->coverage =
      EvaluateCoverage(work->surface, work->photos.photos, *state.region, options, job);
  WriteCoverageMap(work->coverage, work->files.coverage_ply());
  WriteCoverageSummary(work->coverage, ThresholdsOf(options), work->files.coverage_json());
}

// Registered or not.
int NumPhotos(const SparseUpdateResult& sparse) {
  return static_cast<int>(sparse.registered.size() + sparse.unregistered.size());
}

// Where the vehicle is: at the last photo that was taken.
Eigen::Vector3d VehiclePosition(const PhotoSet& photos) {
  return CameraCenter(photos.photos.back().cam_from_world);
}

// The last flight of a vehicle, simulated or real, takes what is left of Session.max_photos; a
// person flies what is planned, or not. With nothing left a whole flight is planned, for whoever
// goes on with a higher limit.
int ViewsOfNextFlight(const IterationContext& context, int photos) {
  const StageOptions& options = *context.options;
  const bool has_vehicle = context.truth != nullptr || options.session.IsRealVehicle();
  const int left = options.session.max_photos - photos;
  return has_vehicle && left > 0 ? std::min(options.nbv.num_views, left) : options.nbv.num_views;
}

// Options that views share with session, coverage and path.
NextBestViewOptions ForPlanning(const IterationContext& context, int photos) {
  const StageOptions& options = *context.options;
  NextBestViewOptions nbv = options.nbv;
  nbv.num_views = ViewsOfNextFlight(context, photos);
  nbv.visibility = options.coverage.visibility;
  nbv.speed_m_s = options.path.speed_m_s;
  nbv.yaw_rate_deg_s = options.path.yaw_rate_deg_s;
  nbv.hover_s = options.path.hover_s;
  return nbv;
}

void RunPlanning(const IterationContext& context, const SessionState& state, Work* work,
                 const JobControl& job) {
  const StageOptions& options = *context.options;
  const Eigen::Vector3d start = VehiclePosition(work->photos);
  PathOptions path_options = options.path;
  ReadZones(work->sparse.frame, &path_options);
  ReadVouchedPhotos(context.workspace.root(), &path_options);
  std::shared_ptr<const FreeSpace> space;
  Timed("nbv", work, job, [&] {
    space = std::make_shared<const FreeSpace>(
        KnownSpace(work->surface, work->photos.photos, start, path_options));
    const NextBestViewOptions nbv = ForPlanning(context, NumPhotos(work->sparse));
    ViewPlanInput input{work->coverage, work->surface.mesh, work->photos.photos};
    input.camera = work->photos.photos.front().camera;
    input.first_id = state.next_view_id;
    input.points = &work->photos.points;
    input.may_fly = FlyablePositions(space, path_options);
    input.may_reach = ReachablePositions(space, start, path_options);
    input.limits = &path_options.limits;
    input.limits_margin_m = path_options.position_error_m;
    input.start = start;
    work->plan = PlanNextViews(input, nbv, job);
    if (!work->plan.explanation.empty()) job.Warn("next best views: " + work->plan.explanation);
    WriteViews(work->plan.views, work->sparse.frame, work->files.views_json());
  });
  Timed("path", work, job, [&] {
    work->path = PlanPath(start, work->plan.views, *space, path_options, job);
    WritePath(work->path, work->sparse.frame, work->files.path_json());
  });
}

void WriteMission(const IterationContext& context, const SessionState& state, const Work& work,
                  const JobControl& job) {
  if (!work.sparse.frame.origin) {
    job.Warn("no mission file: the world has no origin on Earth (positions were local)");
    return;
  }
  MissionOptions options = context.options->mission;
  if (options.home_lat_deg == 0 && options.home_lon_deg == 0 && options.home_below_origin_m == 0) {
    // A simulated vehicle stands on the lowest ground. Of a real one only its photos can tell: a
    // plan with wrong heights would be flown into the ground.
    const auto below_m = context.truth != nullptr
                             ? std::optional(-state.region->box.min().z())
                             : TakeOffBelowOrigin(work.photos, context.sparse.image_path);
    if (!below_m) {
      job.Warn(
          "no mission file: the photos do not say how high above the take-off place they were "
          "taken; say how far it lies below the first photo by --Mission.home_below_origin_m, here "
          "or to mission_exporter");
      return;
    }
    options.home_below_origin_m = *below_m;
  }
  std::string plan;
  try {
    plan = QgcPlan(work.path, work.sparse.frame, options);
  } catch (const Error& error) {  // the path is there, and the session goes on by it
    job.Warn(std::string("no mission file: ") + error.what());
    return;
  }
  WriteFileAtomically(work.files.mission_plan(), plan);
}

void Evaluate(const IterationContext& context, const Work& work, IterationSummary* summary,
              const JobControl& job) {
  const auto true_poses = PoseOfPhoto(ReadTruePoses(context.true_poses_path));
  const std::vector<CameraPair> pairs = PairCameras(work.sparse.model, true_poses);
  const EvaluationOptions& options = context.options->evaluation;
  const ModelAlignment alignment =
      AlignModel(work.surface.mesh, context.truth->model, pairs, options, job);
  const EvaluationResult result =
      EvaluateModel(TransformMesh(alignment.truth_from_model, work.surface.mesh),
                    context.truth->model, options, job);
  WriteFileAtomically(work.files.folder / "evaluation.json",
                      EvaluationToJson(result, alignment, options));
  summary->mean_error_m = result.errors.mean_m;
  summary->rms_error_m = result.errors.rms_m;
  for (const ThresholdScore& score : result.scores) {
    summary->completeness.push_back({ThresholdKey(score.threshold_m), score.completeness});
  }
}

// covered / (covered + uncovered ones that a view could see well).
double ReachableCoveredRatio(const Work& work) {
  const auto covered = static_cast<double>(work.coverage.Count(CoverageClass::kCovered));
  const double all = covered + static_cast<double>(work.plan.reachable_uncovered);
  return all > 0 ? covered / all : 1.0;
}

IterationSummary Summarize(const Work& work) {
  IterationSummary summary;
  summary.registered = static_cast<int>(work.sparse.registered.size());
  summary.photos = NumPhotos(work.sparse);
  summary.unregistered = work.sparse.unregistered;
  summary.covered_ratio = work.coverage.CoveredRatio();
  return summary;
}

StageOptions OptionsForSite(const IterationContext& context, const PhotoSet& photos,
                            SessionState* state, const JobControl& job) {
  if (!context.options->session.fit_to_site) return *context.options;
  if (!state->site_gsd_mm) {
    state->site_gsd_mm = SiteGroundSamplingDistanceMm(photos);
    char line[160];
    std::snprintf(line, sizeof line,
                  "  fitted to the site: wanted resolution %.1f mm a pixel "
                  "(--Coverage.ground_sampling_distance_mm sets another)",
                  *state->site_gsd_mm);
    job.Info(line);
  }
  return FitToSite(*context.options, *state->site_gsd_mm);
}

}  // namespace

IterationResult RunIteration(const IterationContext& given, SessionState* state,
                             const JobControl& job) {
  const StageTimer timer;
  Work work;
  work.iteration = state->iterations_done;
  work.observer = given.observer;
  work.files.folder = given.workspace.iteration(state->iterations_done);
  Timed("sparse", &work, job, [&] { RunSparse(given, *state, &work, job); });
  RunStereo(given, &work, job);
  const StageOptions options = OptionsForSite(given, work.photos, state, job);
  IterationContext context = given;
  context.options = &options;
  Timed("surface", &work, job, [&] { RunSurface(context, state, &work, job); });
  Timed("coverage", &work, job, [&] { RunCoverage(context, *state, &work, job); });

  IterationResult result;
  result.summary = Summarize(work);
  if (work.sparse.frame.is_metric_enu) {
    RunPlanning(context, *state, &work, job);
    result.stop_reason = work.plan.stop_reason;
    result.summary.reachable_covered_ratio = ReachableCoveredRatio(work);
    result.summary.planned_views = CountViews(work.path.waypoints);
    if (*result.summary.reachable_covered_ratio >= context.options->session.target_covered_ratio) {
      result.stop_reason = "covered";
    } else if (result.stop_reason.empty() && result.summary.planned_views == 0) {
      result.stop_reason = "nothing_reachable";
    }
    if (result.stop_reason.empty()) WriteMission(context, *state, work, job);
    state->next_view_id += static_cast<int>(work.plan.views.size());
  } else {
    result.planning_refusal =
        "the model has no metric scale: give photos with GPS, --geo_path or --pose_prior_path";
  }
  if (context.truth != nullptr) {
    Timed("evaluation", &work, job, [&] { Evaluate(context, work, &result.summary, job); });
  }
  if (context.options->session.pictures) {
    Timed("pictures", &work, job, [&] {
      WriteIterationPictures(
          {work.photos, work.stereo.views, work.surface, work.coverage, work.plan.views, work.path},
          work.files.pictures());
    });
  }
  for (const auto& [stage, cost] : work.cost) result.summary.stage_wall_s[stage] = cost.wall_s;
  result.summary.wall_s = timer.Stop().wall_s;
  WriteFileAtomically(work.files.timing_json(), StageCostsToJson(work.cost));
  return result;
}

}  // namespace colmap_ext
