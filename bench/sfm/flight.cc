#include "flight.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <random>

#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

// Radius, height and the height aimed at change from ring to ring by irrational steps, so that no
// two rings repeat each other however many there are.
PlannedView ViewOnRing(int index) {
  constexpr double kGolden = 0.6180339887498949, kSilver = 0.4142135623730951;
  const int ring = index / kPhotosInRing;
  const auto part = [&](double step) { return std::fmod(ring * step, 1.0); };
  const double turn = 2 * M_PI * (index % kPhotosInRing + part(kGolden)) / kPhotosInRing;
  const double radius_m = 26 - 6 * part(kSilver);
  const double height_m = 9 + 18 * part(kGolden);
  const double aim_m = 4 + 8 * part(kSilver);
  PlannedView view;
  view.id = index;
  view.position = {radius_m * std::sin(turn), radius_m * std::cos(turn), height_m};
  view.direction.yaw_rad = NormalizeAngle(turn + M_PI);
  view.direction.pitch_rad = std::atan2(aim_m - height_m, radius_m);
  return view;
}

std::string NameOf(int index) {
  char name[32];
  std::snprintf(name, sizeof(name), "photo_%04d.jpg", index);
  return name;
}

void RenderPhotos(const std::vector<int>& indices, double texel_scale,
                  const std::filesystem::path& folder, const JobControl& job) {
  const TexturedScene scene = MakeScene("church", 1, texel_scale);
  const Renderer renderer(scene, {});
  SimulatedCameraOptions options;
  options.gps_noise_m = 0;
  const SimulatedCamera camera(renderer, scene.origin, options);
  std::filesystem::create_directories(folder);
  std::atomic<std::size_t> done = 0;
  ParallelFor(indices.size(), [&](std::size_t i) {
    camera.CapturePhoto(ViewOnRing(indices[i]), folder / NameOf(indices[i]));
    job.Progress("rendering", ++done, indices.size());
  });
}

}  // namespace

Flight FlyAroundChurch(int num_photos, double texel_scale, const std::filesystem::path& folder,
                       const JobControl& job) {
  const TexturedScene coarse = MakeScene("church", 1, 16);  // quick: the same shape
  Flight flight;
  flight.origin = coarse.origin;
  flight.scene_size_m = BoundsOf(coarse.Truth().model).diagonal().norm();
  std::vector<int> wanted;
  for (int i = 0; i < num_photos; ++i) {
    const PlannedView view = ViewOnRing(i);
    flight.names.push_back(NameOf(i));
    flight.cam_from_world[NameOf(i)] = CamFromWorld(view.position, view.direction);
    flight.position[NameOf(i)] = GeoFromEnu(coarse.origin, view.position);
    if (!std::filesystem::exists(folder / NameOf(i))) wanted.push_back(i);
  }
  if (!wanted.empty()) RenderPhotos(wanted, texel_scale, folder, job);
  return flight;
}

std::map<std::string, GeoPosition> NoisyPositions(const Flight& flight, double sigma_m,
                                                  std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> noise(0, sigma_m);
  std::map<std::string, GeoPosition> positions;
  for (const std::string& name : flight.names) {
    const Eigen::Vector3d truth = EnuFromGeo(flight.origin, flight.position.at(name));
    const Eigen::Vector3d error(noise(generator), noise(generator), noise(generator));
    positions[name] = GeoFromEnu(flight.origin, truth + error);
  }
  return positions;
}

}  // namespace colmap_ext
