#include "plans.h"

#include "colmap_ext/mission/flight_patterns.h"
#include "colmap_ext/scene/true_poses.h"
#include "support/simulated_session.h"

namespace colmap_ext {

double MetresOf(const std::vector<PlannedView>& views) {
  double metres = 0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    metres += (views[i].position - views[i - 1].position).norm();
  }
  return metres;
}

FlownPlan ManualPlan(const Site& site, const std::string& pattern, int num_views) {
  FlightPatternOptions options;
  options.name = pattern;
  options.num_views = num_views;
  options.distance_m = site.is_indoor() ? 1.0 : 10.0;
  options.height_above_top_m = site.is_indoor() ? 0.2 : 2.0;
  return {pattern, MakeFlightPattern(SiteOfBox(site.model), options)};
}

FlownPlan TrimmedTo(const FlownPlan& plan, double metres) {
  FlownPlan trimmed{plan.name, {}};
  double flown = 0;
  for (const PlannedView& view : plan.views) {
    if (!trimmed.views.empty()) flown += (view.position - trimmed.views.back().position).norm();
    if (flown > metres && trimmed.views.size() >= 3) break;
    trimmed.views.push_back(view);
  }
  return trimmed;
}

FlownPlan ActivePlan(const Site& site, const ActiveSession& session,
                     const std::filesystem::path& workspace, const JobControl& job) {
  RunSimulatedSession(
      workspace,
      {"--scene", site.name, "--preset", site.is_indoor() ? "indoor" : "outdoor",
       "--Session.max_photos", std::to_string(session.max_photos), "--Session.max_iterations", "50",
       "--InitialFlight.num_views", std::to_string(session.first_views), "--NextBestView.num_views",
       std::to_string(session.flight_views), "--NextBestView.strategy", session.strategy,
       "--Simulation.seed", std::to_string(session.seed)},
      job);
  FlownPlan plan{session.strategy, {}};
  for (const TruePose& pose : ReadTruePoses(workspace / "truth" / "poses.txt")) {
    plan.views.push_back({.id = static_cast<int>(plan.views.size()),
                          .position = CameraCenter(pose.cam_from_world),
                          .direction = ViewDirectionOf(pose.cam_from_world)});
  }
  return plan;
}

}  // namespace colmap_ext
