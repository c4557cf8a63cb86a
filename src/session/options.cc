#include <initializer_list>

#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/session/presets.h"
#include "colmap_ext/session/session_options.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {

std::string SessionOptions::Check() const {
  if (max_iterations < 1) return "Session.max_iterations must be at least 1";
  if (max_photos < 3) return "Session.max_photos must be at least 3";
  if (!(target_covered_ratio > 0 && target_covered_ratio <= 1)) {
    return "Session.target_covered_ratio must be above 0 and at most 1";
  }
  if (max_image_size_px < 160) return "Session.max_image_size_px must be at least 160";
  if (vehicle.empty()) return "Session.vehicle must be simulated, embedded or a connection";
  if (IsRealVehicle()) ParseMavLinkUrl(vehicle);  // throws UsageError
  if (personality != "px4" && personality != "ardupilot") {
    return "Session.personality must be px4 or ardupilot";
  }
  if (!(simulation_speed >= 0.1 && simulation_speed <= 100)) {
    return "Session.simulation_speed must be from 0.1 to 100";
  }
  return "";
}

std::string StageOptions::Check() const {
  for (const std::string& complaint :
       {session.Check(), sparse.Check(), superpixels.Check(), stereo.Check(), points.Check(),
        surface.Check(), coverage.Check(), region.Check(), nbv.Check(), path.Check(),
        initial_flight.Check(), mission.Check(), simulation.Check(), render.Check(), flight.Check(),
        flight_plan.Check(), evaluation.Check(), page.Check()}) {
    if (!complaint.empty()) return complaint;
  }
  return "";
}

void BindOptions(OptionSet& set, StageOptions* options) {
  SessionOptions& session = options->session;
  set.Add("Session", "max_iterations", &session.max_iterations,
          "stop after so many iterations, the first flight included [>= 1]");
  set.Add("Session", "max_photos", &session.max_photos,
          "at most so many photos: the last flight is cut to what is left [>= 3]");
  set.Add("Session", "target_covered_ratio", &session.target_covered_ratio,
          "end as covered when this part of what can be reached is covered [0 … 1]");
  set.Add("Session", "max_image_size_px", &session.max_image_size_px,
          "photos are scaled down to this width for the dense stages [px, >= 160]");
  set.Add("Session", "fit_to_site", &session.fit_to_site,
          "fit the distances of coverage, views and path to what the first photos resolve");
  set.Add("Session", "pictures", &session.pictures, "write the pictures of every iteration");
  set.Add("Session", "dense_output", &session.dense_output,
          "write meshes/ and dense/ (COLMAP's maps) of every iteration; 5 MB a photo");
  set.Add("Session", "full_resolution", &session.full_resolution,
          "also photos at full resolution, in images_full/");
  set.Add("Session", "vehicle", &session.vehicle,
          "simulated (flight daemon and drone as processes), embedded (only the renderer) or, with "
          "--image_path, the connection of a real vehicle, udpin://0.0.0.0:14550 …");
  set.Add("Session", "personality", &session.personality,
          "of the simulated drone: px4 or ardupilot");
  set.Add("Session", "simulation_speed", &session.simulation_speed,
          "simulated seconds a second [0.1 … 100]");
  BindOptions(set, &options->sparse);
  BindOptions(set, &options->superpixels);
  BindOptions(set, &options->stereo);
  BindOptions(set, &options->points);
  BindOptions(set, &options->surface);
  BindOptions(set, &options->coverage);
  BindOptions(set, &options->region);
  BindOptions(set, &options->nbv);
  BindOptions(set, &options->path);
  BindOptions(set, &options->initial_flight);
  BindOptions(set, &options->mission);
  BindOptions(set, &options->simulation);
  BindOptions(set, &options->render);
  BindOptions(set, &options->flight);
  BindOptions(set, &options->flight_plan);
  BindOptions(set, &options->evaluation);
  BindOptions(set, &options->page);
}

StageOptions FitToSite(const StageOptions& options, double gsd_mm) {
  StageOptions fitted = options;
  const double factor = gsd_mm / options.coverage.ground_sampling_distance_mm;
  fitted.coverage.ground_sampling_distance_mm = gsd_mm;
  fitted.surface.ground_sampling_distance_mm = gsd_mm;
  for (double* distance_m :
       {&fitted.nbv.grid_spacing_m, &fitted.nbv.nms_radius_m,
        &fitted.nbv.max_distance_to_existing_m, &fitted.nbv.plane_step_m, &fitted.nbv.max_range_m,
        &fitted.path.cell_size_m, &fitted.path.detour_margin_m, &fitted.path.flown_margin_m,
        &fitted.path.confident_spacing_m}) {
    *distance_m *= factor;
  }
  return fitted;
}

void ApplyPreset(const std::string& preset, const OptionSet& set, StageOptions* options) {
  if (preset == "outdoor") return;  // the defaults
  if (preset != "indoor") {
    throw UsageError("--preset " + preset + ": must be outdoor or indoor");
  }
  // The paper's Vicon room: cardboard buildings of a metre or two, photographed from a metre or
  // two.
  const auto assign = [&set](const char* name, double value, double* option) {
    if (!set.IsSet(name)) *option = value;
  };
  assign("InitialFlight.offset_m", 1.0, &options->initial_flight.offset_m);
  assign("InitialFlight.height_above_top_m", 0.2, &options->initial_flight.height_above_top_m);
  assign("NextBestView.safe_distance_m", 0.6, &options->nbv.safe_distance_m);
  assign("NextBestView.grid_spacing_m", 0.2, &options->nbv.grid_spacing_m);
  assign("NextBestView.plane_step_m", 0.1, &options->nbv.plane_step_m);
  assign("NextBestView.min_altitude_m", 0.3, &options->nbv.min_altitude_m);
  assign("NextBestView.nms_radius_m", 0.2, &options->nbv.nms_radius_m);
  assign("NextBestView.max_distance_to_existing_m", 0.5, &options->nbv.max_distance_to_existing_m);
  assign("Path.safe_distance_m", 0.5, &options->path.safe_distance_m);
  assign("Path.position_error_m", 0.05, &options->path.position_error_m);
  assign("Path.climb_speed_m_s", 0.5, &options->path.climb_speed_m_s);
  assign("Path.descent_speed_m_s", 0.5, &options->path.descent_speed_m_s);
  assign("Path.confident_spacing_m", 0.2, &options->path.confident_spacing_m);
  assign("Path.cell_size_m", 0.15, &options->path.cell_size_m);
  assign("Path.detour_margin_m", 1.0, &options->path.detour_margin_m);
  assign("Path.flown_margin_m", 0.5, &options->path.flown_margin_m);
  assign("Path.start_tolerance_m", 0.2, &options->path.start_tolerance_m);
  assign("Path.speed_m_s", 0.5, &options->path.speed_m_s);
  assign("Coverage.ground_sampling_distance_mm", 8.0,
         &options->coverage.ground_sampling_distance_mm);
  assign("Pairing.max_distance_m", 1.5, &options->sparse.pairing.max_distance_m);
  assign("Georegistration.max_residual_m", 0.5, &options->sparse.georegistration.max_residual_m);
  assign("Georegistration.loss_scale_m", 0.05, &options->sparse.georegistration.loss_scale_m);
  assign("Simulation.gps_noise_m", 0.01, &options->simulation.gps_noise_m);  // a Vicon room
  assign("Flight.settle_distance_m", 0.1, &options->flight.settle_distance_m);
  assign("Flight.settle_speed_m_s", 0.1, &options->flight.settle_speed_m_s);
  assign("Flight.takeoff_height_m", 0.5, &options->flight.takeoff_height_m);
  assign("FlightPlan.fence_margin_m", 2.0, &options->flight_plan.fence_margin_m);
  assign("FlightPlan.transit_margin_m", 0.5, &options->flight_plan.transit_margin_m);
  assign("FlightPlan.min_relative_height_m", 0.2, &options->flight_plan.min_relative_height_m);
  assign("Mission.min_relative_height_m", 0.2, &options->mission.min_relative_height_m);
  assign("ModelEvaluator.sample_spacing_m", 0.02, &options->evaluation.sample_spacing_m);
}

}  // namespace colmap_ext
