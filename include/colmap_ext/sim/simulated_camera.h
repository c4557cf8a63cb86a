// The camera of a simulated drone: renders what a planned view sees and writes it as a photo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct SimulatedCameraOptions {
  int width = 640;           // px of the photos that are sent at once; [16, 16384]
  int height = 368;          // px; [16, 16384]
  double focal_px = 480;     // of these photos, both axes (67 degrees across); [8, 1e6]
  int full_width = 1920;     // px of the photos in full resolution; [16, 16384]
  int full_height = 1080;    // px; [16, 16384]
  double gps_noise_m = 0.3;  // sigma of each axis, written into EXIF; [0, 100]
  int jpeg_quality = 92;     // [1, 100]
  std::uint64_t seed = 1;    // of GPS and sensor noise

  std::string Check() const;

  PinholeCamera LowCamera() const;
  // A photo shows the same field of view in both resolutions, so this is ScaleTo(LowCamera(), full
  // size): with the default sizes its focal lengths are 1440 and 1408.7 px.
  PinholeCamera FullCamera() const;
};
void BindOptions(OptionSet& set, SimulatedCameraOptions* options);  // section "Simulation"

enum class PhotoResolution { kLow, kFull };

struct CapturedPhoto {
  PinholeCamera camera;    // of the photo written
  Rigid3d cam_from_world;  // the true pose
  GeoPosition gps;         // as written into EXIF, with noise
};

// Not owning: `renderer` must outlive it. Methods may be called from many threads.
class SimulatedCamera {
 public:
  // `origin` is that of the scene's ENU frame. Throws UsageError for invalid options.
  SimulatedCamera(const Renderer& renderer, const GeoPosition& origin,
                  const SimulatedCameraOptions& options);

  // Renders `view` and writes a JPEG with EXIF (GPS position with noise, focal length, make and
  // model, heading and pitch), replaced atomically. Depends on (seed, view.id, pose) only, not on
  // the order or number of calls; both resolutions carry the same GPS position. Throws Error when
  // the file cannot be written.
  CapturedPhoto CapturePhoto(const PlannedView& view, const std::filesystem::path& jpeg_path,
                             PhotoResolution resolution = PhotoResolution::kLow) const;
  // The same with a GPS position that somebody else measured.
  CapturedPhoto CapturePhoto(const PlannedView& view, const GeoPosition& gps,
                             const std::filesystem::path& jpeg_path,
                             PhotoResolution resolution) const;

  const SimulatedCameraOptions& options() const { return options_; }

 private:
  const Renderer& renderer_;
  GeoPosition origin_;
  SimulatedCameraOptions options_;
};

}  // namespace colmap_ext
