// The site of a simulated session: scene, renderer, camera and truth.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/scene/truth.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

class SimulatedSite {
 public:
  // Makes or loads the scene that `inputs` name.
  SimulatedSite(const SessionInputs& inputs, const StageOptions& options, const JobControl& job);

  SimulatedSite(const SimulatedSite&) = delete;
  SimulatedSite& operator=(const SimulatedSite&) = delete;

  // What the pilot knows beforehand: where the object stands and how large it is.
  RegionOfInterest Surroundings() const;
  const GroundTruth& truth() const { return truth_; }

  // Photographs every waypoint that has a view, into workspace.images(). A photo that is there
  // already stays: it has the same content. Also brings truth/poses.txt up to date.
  void Capture(const std::vector<Waypoint>& waypoints, const Workspace& workspace,
               const JobControl& job) const;

  // Name of the photo of a view, in the order of the ids.
  static std::string PhotoName(int view_id);
  static std::filesystem::path TruePosesPath(const Workspace& workspace);

 private:
  void CaptureOnce(const SimulatedCamera& camera, const PlannedView& view,
                   const std::filesystem::path& path, PhotoResolution resolution) const;

  TexturedScene scene_;
  GroundTruth truth_;
  RenderOptions render_options_;
  SimulatedCameraOptions camera_options_;
  // Made when the first photo is taken here: a drone brings its own.
  mutable std::optional<Renderer> renderer_;
  bool full_resolution_;
};

}  // namespace colmap_ext
