// Photos, sparse, fast and dense model of a flight over a simulated scene: made once, and kept.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct SiteOptions {
  std::uint64_t scene_seed = 1;
  double texel_scale = 2;    // 2.8 cm on the church, a pixel being 3 cm and more
  int dense_width_px = 640;  // of the photos for the dense model; coverage sees them 640 wide
  bool true_poses = true;    // else those of structure from motion
};

// A scene with all its surfaces.
struct Site {
  std::string name;
  TriangleMesh truth;  // model and ground
  BoundingBox model;   // bounds without ground
  BoundingBox region;  // of interest: the model and a little ground around it

  bool is_indoor() const { return name == "boxes"; }
};
Site MakeSite(const std::string& scene, const SiteOptions& options);

struct FlightModels {
  std::filesystem::path sparse;  // in the truth's frame
  std::filesystem::path fused;   // the fast model's cloud
  std::filesystem::path surface;
  std::filesystem::path dense_surface;
  std::filesystem::path true_poses;  // of the photos
  int num_views = 0;                 // planned
};

// Runs scene_renderer, sparse_updater, superpixel_stereo, surface_reconstructor and
// dense_reconstructor on photos of these views in `folder`, each unless its result is there.
FlightModels MakeFlightModels(const Site& site, const std::vector<PlannedView>& views,
                              const std::filesystem::path& folder, const SiteOptions& options,
                              const JobControl& job);

// "x_min,…,z_max" as --RegionOfInterest.box takes it.
std::string BoxText(const BoundingBox& box);

}  // namespace colmap_ext
