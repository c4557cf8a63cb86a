// Every option of a session, in one place: what session.ini holds.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/coverage/coverage.h"
#include "colmap_ext/coverage/region.h"
#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/plan_mission.h"
#include "colmap_ext/mission/mission.h"
#include "colmap_ext/mission/patterns.h"
#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/report/session_page.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct SessionOptions {
  int max_iterations = 20;  // stop after so many iterations, the first flight included, >= 1
  int max_photos = 200;     // at most so many: the last flight is cut to what is left, >= 3
  // The session ends as covered when this part of the iso-points that a view could see well is
  // covered, (0, 1]. The last points take most photos.
  double target_covered_ratio = 0.98;
  // Photos are scaled down to this width for the dense stages, >= 160 px (paper: 640).
  int max_image_size_px = 1024;
  // Fit the distances of coverage, views and path to the site: what the first photos resolve (1.5
  // times their median pixel on the surface) becomes the wanted ground sampling distance, and the
  // spacings of view and path planning grow or shrink with it. The safe distance stays.
  bool fit_to_site = false;
  bool pictures = true;  // write the pictures of every iteration
  // Write meshes/ and dense/ (COLMAP's depth and normal maps) of every iteration: 5 MB a photo.
  bool dense_output = false;
  bool full_resolution = false;  // also photos at full resolution, in images_full/
  // Who takes the photos of a simulated session: "simulated" (flight daemon and simulated drone as
  // child processes) or "embedded" (the renderer in this process, without a flight). Anything else
  // is the connection of a real vehicle, which flies after a person's photos (docs/flying.md).
  std::string vehicle = "simulated";
  std::string personality = "px4";  // of the simulated drone: px4 or ardupilot
  double simulation_speed = 10;     // simulated seconds in one of the wall's, [0.1, 100]

  bool IsRealVehicle() const { return vehicle != "simulated" && vehicle != "embedded"; }
  std::string Check() const;
};

// The options of all stages, each under its own section.
struct StageOptions {
  SessionOptions session;
  SparseUpdateOptions sparse;
  SuperpixelOptions superpixels;
  SuperpixelStereoOptions stereo;
  PointSamplerOptions points;
  SurfaceOptions surface;
  CoverageOptions coverage;
  RegionOptions region;
  NextBestViewOptions nbv;
  PathOptions path;
  InitialFlightOptions initial_flight;
  MissionOptions mission;
  SimulatedCameraOptions simulation;
  RenderOptions render;
  FlightOptions flight;
  FlightPlanOptions flight_plan;
  EvaluationOptions evaluation;
  PageOptions page;

  // The first complaint of any of them; empty when all is well.
  std::string Check() const;
};

void BindOptions(OptionSet& set, StageOptions* options);

// Options for a site whose wanted ground sampling distance is `gsd_mm`: what
// SessionOptions::fit_to_site does. Returns a copy.
StageOptions FitToSite(const StageOptions& options, double gsd_mm);

}  // namespace colmap_ext
