// The photos of the benchmark: flights around a simulated scene, with exact poses.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct Flight {
  std::vector<std::string> names;  // in the order of the flight
  std::map<std::string, Rigid3d> cam_from_world;
  std::map<std::string, GeoPosition> position;  // exact
  GeoPosition origin;                           // of the scene
  double scene_size_m = 0;                      // diagonal of the model's box
};

inline constexpr int kPhotosInRing = 32;

// Rings of 32 views around the church, each with its own radius, height and aim; the first two make
// the 64 photos that a model begins with. Photos that `folder` has already are not rendered again.
Flight FlyAroundChurch(int num_photos, double texel_scale, const std::filesystem::path& folder,
                       const JobControl& job);

// Positions with Gaussian noise of `sigma_m` on each axis.
std::map<std::string, GeoPosition> NoisyPositions(const Flight& flight, double sigma_m,
                                                  std::uint64_t seed);

}  // namespace colmap_ext
