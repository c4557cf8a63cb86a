#include "session/simulated_site.h"

#include <cstdio>

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

TexturedScene MakeOrLoadScene(const SessionInputs& inputs, const StageOptions& options,
                              const JobControl& job) {
  if (!inputs.scene.empty()) return MakeScene(inputs.scene, options.simulation.seed);
  return LoadScene(inputs.scene_path, LoadSceneOptions(), job);
}

}  // namespace

SimulatedSite::SimulatedSite(const SessionInputs& inputs, const StageOptions& options,
                             const JobControl& job)
    : scene_(MakeOrLoadScene(inputs, options, job)),
      truth_(scene_.Truth()),
      render_options_(options.render),
      camera_options_(options.simulation),
      full_resolution_(options.session.full_resolution) {}

RegionOfInterest SimulatedSite::Surroundings() const { return {BoundsOf(truth_.model)}; }

std::string SimulatedSite::PhotoName(int view_id) {
  char name[32];
  std::snprintf(name, sizeof name, "view_%05d.jpg", view_id);
  return name;
}

std::filesystem::path SimulatedSite::TruePosesPath(const Workspace& workspace) {
  return workspace.root() / "truth" / "poses.txt";
}

void SimulatedSite::Capture(const std::vector<Waypoint>& waypoints, const Workspace& workspace,
                            const JobControl& job) const {
  std::vector<PlannedView> views;
  for (const Waypoint& waypoint : waypoints) {
    if (waypoint.view_id < 0) continue;
    PlannedView view;
    view.id = waypoint.view_id;
    view.position = waypoint.position;
    view.direction = waypoint.direction;
    views.push_back(view);
  }
  if (!renderer_) renderer_.emplace(scene_, render_options_);
  const SimulatedCamera camera(*renderer_, truth_.origin, camera_options_);
  std::vector<TruePose> poses;
  for (std::size_t i = 0; i < views.size(); ++i) {
    job.ThrowIfCancelled();
    const std::string name = PhotoName(views[i].id);
    CaptureOnce(camera, views[i], workspace.images() / name, PhotoResolution::kLow);
    if (full_resolution_) {
      CaptureOnce(camera, views[i], workspace.images_full() / name, PhotoResolution::kFull);
    }
    poses.push_back({name, CamFromWorld(views[i].position, views[i].direction)});
    job.Progress("photos", i + 1, views.size());
  }
  UpdateTruePoses(poses, TruePosesPath(workspace));
}

void SimulatedSite::CaptureOnce(const SimulatedCamera& camera, const PlannedView& view,
                                const std::filesystem::path& path,
                                PhotoResolution resolution) const {
  if (!std::filesystem::exists(path)) camera.CapturePhoto(view, path, resolution);
}

}  // namespace colmap_ext
