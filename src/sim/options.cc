#include <cmath>

#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"

namespace colmap_ext {
namespace {

// Also false for NaN.
bool InRange(double value, double low, double high) { return value >= low && value <= high; }

}  // namespace

std::string RenderOptions::Check() const {
  const int n = static_cast<int>(std::lround(std::sqrt(std::max(0, samples_per_pixel))));
  if (n < 1 || n > 8 || n * n != samples_per_pixel) {
    return "Renderer.samples_per_pixel must be 1, 4, 9, 16, 25, 36, 49 or 64";
  }
  if (!InRange(sun_azimuth_deg, -360, 360)) {
    return "Renderer.sun_azimuth_deg must be in [-360, 360]";
  }
  if (!InRange(sun_elevation_deg, 1, 90)) return "Renderer.sun_elevation_deg must be in [1, 90]";
  if (!InRange(sun_strength, 0, 10)) return "Renderer.sun_strength must be in [0, 10]";
  if (!InRange(sky_strength, 0, 10)) return "Renderer.sky_strength must be in [0, 10]";
  if (ambient_rays < 0 || ambient_rays > 1024) {
    return "Renderer.ambient_rays must be in [0, 1024]";
  }
  if (!InRange(exposure, 0.01, 100)) return "Renderer.exposure must be in [0.01, 100]";
  if (!InRange(sensor_noise_sigma, 0, 50)) {
    return "Renderer.sensor_noise_sigma must be in [0, 50]";
  }
  if (!InRange(shutter_s, 0, 1)) return "Renderer.shutter_s must be in [0, 1]";
  return "";
}

void BindOptions(OptionSet& set, RenderOptions* options) {
  const std::string section = "Renderer";
  set.Add(section, "samples_per_pixel", &options->samples_per_pixel,
          "rays a pixel, on a regular grid (1, 4, 9, 16, 25, 36, 49 or 64)");
  set.Add(section, "sun_azimuth_deg", &options->sun_azimuth_deg,
          "where the sun stands, clockwise from north (degrees, [-360, 360])");
  set.Add(section, "sun_elevation_deg", &options->sun_elevation_deg,
          "the sun's height above the horizon (degrees, [1, 90])");
  set.Add(section, "sun_strength", &options->sun_strength,
          "light of the sun; 0: overcast ([0, 10])");
  set.Add(section, "sky_strength", &options->sky_strength, "light of the sky ([0, 10])");
  set.Add(section, "shadows", &options->shadows, "shadows of the sun (0 or 1)");
  set.Add(section, "ambient_rays", &options->ambient_rays,
          "rays a vertex that find how much sky recesses see; 0: none ([0, 1024])");
  set.Add(section, "exposure", &options->exposure, "factor on the light ([0.01, 100])");
  set.Add(section, "sensor_noise_sigma", &options->sensor_noise_sigma,
          "Gaussian noise of the sensor (grey levels of 255, [0, 50])");
  set.Add(section, "shutter_s", &options->shutter_s,
          "time over which a moving camera blurs; 0: no blur (s, [0, 1])");
}

std::string SimulatedCameraOptions::Check() const {
  for (const int size : {width, height, full_width, full_height}) {
    if (size < 16 || size > 16384) {
      return "Simulation.width, height, full_width and full_height must be in [16, 16384]";
    }
  }
  if (!InRange(focal_px, 8, 1e6)) return "Simulation.focal_px must be in [8, 1e6]";
  if (!InRange(gps_noise_m, 0, 100)) return "Simulation.gps_noise_m must be in [0, 100]";
  if (jpeg_quality < 1 || jpeg_quality > 100) return "Simulation.jpeg_quality must be in [1, 100]";
  return "";
}

void BindOptions(OptionSet& set, SimulatedCameraOptions* options) {
  const std::string section = "Simulation";
  set.Add(section, "width", &options->width, "width of photos (px, [16, 16384])");
  set.Add(section, "height", &options->height, "height of photos (px, [16, 16384])");
  set.Add(section, "focal_px", &options->focal_px,
          "focal length at this size, both axes (px, [8, 1e6])");
  set.Add(section, "full_width", &options->full_width,
          "width of photos in full resolution (px, [16, 16384])");
  set.Add(section, "full_height", &options->full_height,
          "height of photos in full resolution (px, [16, 16384])");
  set.Add(section, "gps_noise_m", &options->gps_noise_m,
          "sigma of the GPS position, each axis (m, [0, 100])");
  set.Add(section, "jpeg_quality", &options->jpeg_quality, "quality of photos ([1, 100])");
  set.Add(section, "seed", &options->seed, "of GPS and sensor noise");
}

}  // namespace colmap_ext
