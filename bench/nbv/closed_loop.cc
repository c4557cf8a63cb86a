#include "closed_loop.h"

#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Counts what is flown, stop by stop.
class Flight {
 public:
  Flight(const PathOptions& options, const LoopStep& so_far) : options_(options), step_(so_far) {}

  // Goes on to a waypoint; true when a photo is taken there.
  bool GoTo(const Waypoint& waypoint) {
    if (!is_first_) {
      const double length_m = (waypoint.position - last_.position).norm();
      step_.length_m += length_m;
      step_.duration_s += length_m / options_.speed_m_s;
    }
    const bool is_photo = waypoint.view_id >= 0;
    if (is_photo) {
      const double turn_rad =
          is_first_ ? 0 : std::abs(NormalizeAngle(waypoint.direction.yaw_rad - heading_rad_));
      step_.duration_s += RadToDeg(turn_rad) / options_.yaw_rate_deg_s + options_.hover_s;
      heading_rad_ = waypoint.direction.yaw_rad;
      ++step_.photos;
    }
    last_ = waypoint;
    is_first_ = false;
    return is_photo;
  }
  LoopStep Step(std::size_t covered) const {
    LoopStep step = step_;
    step.covered = covered;
    return step;
  }

 private:
  const PathOptions& options_;
  LoopStep step_;
  Waypoint last_;
  double heading_rad_ = 0;
  bool is_first_ = true;
};

NextBestViewOptions PlanningOptions(const TrueSite& site, const std::string& strategy) {
  NextBestViewOptions nbv = site.options().nbv;
  nbv.strategy = strategy;
  nbv.visibility = site.options().coverage.visibility;
  nbv.speed_m_s = site.options().path.speed_m_s;
  nbv.yaw_rate_deg_s = site.options().path.yaw_rate_deg_s;
  nbv.hover_s = site.options().path.hover_s;
  return nbv;
}

}  // namespace

LoopResult RunGeometryLoop(const TrueSite& site, const std::string& strategy,
                           std::size_t wanted_covered, int max_photos, bool ask_reach,
                           const JobControl& job) {
  const NextBestViewOptions nbv = PlanningOptions(site, strategy);
  std::vector<PosedPhoto> photos = site.FirstFlight();
  PathOptions path_options = site.options().path;
  if (!path_options.vouch_planned_flights) {
    path_options.vouched_photos.emplace();
    for (const PosedPhoto& photo : photos) path_options.vouched_photos->insert(photo.name);
  }
  CoverageCounter counter = site.NewCounter();
  for (const PosedPhoto& photo : photos) counter.Add(photo);
  LoopResult result;
  result.first_photos = static_cast<int>(photos.size());
  result.steps.push_back({0, counter.NumCovered(), 0, 0});
  while (result.steps.back().photos < max_photos && counter.NumCovered() < wanted_covered) {
    ViewPlanInput input{counter.map(), site.mesh(), photos};
    input.camera = photos.front().camera;
    input.first_id = static_cast<int>(photos.size());
    input.start = CameraCenter(photos.back().cam_from_world);
    const auto space = std::make_shared<const FreeSpace>(
        KnownSpace({site.mesh()}, photos, *input.start, path_options));
    input.may_fly = FlyablePositions(space, path_options);
    const StageTimer timer;
    if (ask_reach) input.may_reach = ReachablePositions(space, *input.start, path_options);
    const ViewPlanResult plan = PlanNextViews(input, nbv, job);
    result.planning_s += timer.Stop().wall_s;
    ++result.iterations;
    result.stop_reason = plan.stop_reason;
    if (plan.views.empty()) break;
    const FlightPath path = PlanPath(*input.start, plan.views, *space, path_options, JobControl());
    result.dropped += static_cast<int>(path.dropped_view_ids.size());
    Flight flight(path_options, result.steps.back());
    bool any = false;
    for (const Waypoint& waypoint : path.waypoints) {
      if (!flight.GoTo(waypoint)) continue;
      any = true;
      PlannedView view;
      view.id = waypoint.view_id;
      view.position = waypoint.position;
      view.direction = waypoint.direction;
      photos.push_back(site.Photograph(view));
      counter.Add(photos.back());
      result.steps.push_back(flight.Step(counter.NumCovered()));
    }
    if (!any) {
      result.stop_reason = "no view can be flown to";
      break;
    }
  }
  result.planned = result.registered = result.steps.back().photos;
  return result;
}

LoopResult RunPhotoLoop(const TrueSite& site, const std::string& strategy, int max_photos,
                        const std::vector<std::string>& arguments, const fs::path& workspace_path,
                        const JobControl& job) {
  const StageOptions& options = site.options();
  ChildProcessOptions child;
  child.arguments = {COLMAP_EXT_PROGRAM,
                     "active_capture",
                     "--workspace_path",
                     workspace_path.string(),
                     "--scene",
                     site.scene(),
                     "--NextBestView.strategy",
                     strategy,
                     "--NextBestView.seed",
                     std::to_string(options.nbv.seed),
                     "--Simulation.seed",
                     std::to_string(options.nbv.seed),
                     "--Session.vehicle",
                     "embedded",
                     "--Session.pictures",
                     "0",
                     "--Session.max_photos",
                     std::to_string(options.initial_flight.num_views + max_photos)};
  child.arguments.insert(child.arguments.end(), arguments.begin(), arguments.end());
  child.log_path = workspace_path.string() + ".log";
  if (RunChildProcess(child, job).exit_code != 0) {
    throw Error("active_capture failed: see " + child.log_path.string());
  }
  const Workspace workspace(workspace_path);
  const SessionSummary summary = ReadSummary(workspace.summary_json());
  const auto pose_of = PoseOfPhoto(ReadTruePoses(workspace.root() / "truth" / "poses.txt"));
  const IterationFiles last{workspace.iteration(static_cast<int>(summary.iterations.size()) - 1)};
  std::set<std::string> registered;
  for (const auto& [id, image] : ReadReconstruction(last.sparse()).images) {
    registered.insert(image.name);
  }
  CoverageCounter counter = site.NewCounter();
  const auto add = [&](int id) {
    char name[32];
    std::snprintf(name, sizeof name, "view_%05d.jpg", id);
    if (!registered.contains(name)) return false;
    PosedPhoto photo;
    photo.camera = options.simulation.LowCamera();
    photo.cam_from_world = pose_of.at(name);
    counter.Add(photo);
    return true;
  };
  LoopResult result;
  result.first_photos = options.initial_flight.num_views;
  for (int id = 0; id < result.first_photos; ++id) add(id);
  result.steps.push_back({0, counter.NumCovered(), 0, 0});
  for (std::size_t i = 0; i + 1 < summary.iterations.size(); ++i) {
    const IterationFiles files{workspace.iteration(static_cast<int>(i))};
    Flight flight(options.path, result.steps.back());
    for (const Waypoint& waypoint : ReadPath(files.path_json()).waypoints) {
      if (!flight.GoTo(waypoint)) continue;
      if (add(waypoint.view_id)) ++result.registered;
      result.steps.push_back(flight.Step(counter.NumCovered()));
    }
    result.planning_s += summary.iterations[i].stage_wall_s.at("nbv");
  }
  result.iterations = static_cast<int>(summary.iterations.size());
  result.planned = result.steps.back().photos;
  result.stop_reason = summary.finished;
  return result;
}

}  // namespace colmap_ext
