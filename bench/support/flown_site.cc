#include "flown_site.h"

#include <Eigen/Geometry>
#include <cstdio>

#include "bench_program.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

using Arguments = std::vector<std::string>;

std::string NumberText(double value) { return FormatNumber("%.9g", value); }

// Runs `colmap_ext <arguments>` unless `result` is there already.
void RunUnlessThere(const fs::path& result, Arguments arguments, const fs::path& log,
                    const JobControl& job) {
  if (fs::exists(result)) return;
  const std::string command = arguments.front();
  RunColmapExt(std::move(arguments), log, job);
  if (!fs::exists(result)) throw Error(command + " did not write " + result.string());
}

void WritePoseList(const std::vector<PlannedView>& views, const fs::path& path) {
  std::string text;
  for (const PlannedView& view : views) {
    char name[32];
    std::snprintf(name, sizeof name, "photo_%04d.jpg", view.id);
    text += name;
    for (const double value :
         {view.position.x(), view.position.y(), view.position.z(), RadToDeg(view.direction.yaw_rad),
          RadToDeg(view.direction.pitch_rad)}) {
      text += " " + NumberText(value);
    }
    text += "\n";
  }
  WriteFileAtomically(path, text);
}

void RenderPhotos(const Site& site, const fs::path& folder, const SiteOptions& options,
                  const JobControl& job) {
  const SimulatedCameraOptions camera;
  const int height = options.dense_width_px * camera.height / camera.width;
  for (const bool full : {false, true}) {
    if (full && options.dense_width_px == camera.width) continue;
    const fs::path output = folder / (full ? "full" : "low");
    RunUnlessThere(
        output / "true_poses.txt",
        {"scene_renderer", "--scene", site.name, "--scene_seed", std::to_string(options.scene_seed),
         "--texel_scale", NumberText(options.texel_scale), "--pose_list_path",
         (folder / "views.txt").string(), "--output_path", output.string(), "--full_resolution",
         full ? "1" : "0", "--Simulation.full_width", std::to_string(options.dense_width_px),
         "--Simulation.full_height", std::to_string(height)},
        folder / "logs" / "render.log", job);
  }
}

void MapPhotos(const fs::path& folder, const JobControl& job) {
  std::string priors;
  for (const TruePose& pose : ReadTruePoses(folder / "low" / "true_poses.txt")) {
    const Eigen::Vector3d center = CameraCenter(pose.cam_from_world);
    priors += pose.name + " " + NumberText(center.x()) + " " + NumberText(center.y()) + " " +
              NumberText(center.z()) + "\n";
  }
  WriteFileAtomically(folder / "priors.txt", priors);
  const PinholeCamera camera = SimulatedCameraOptions().LowCamera();
  RunUnlessThere(
      folder / "sfm" / "images.bin",
      {"sparse_updater", "--image_path", (folder / "low" / "images").string(), "--output_path",
       (folder / "sfm").string(), "--pose_prior_path", (folder / "priors.txt").string(),
       "--camera_params",
       NumberText(camera.fx) + "," + NumberText(camera.cx) + "," + NumberText(camera.cy)},
      folder / "logs" / "sfm.log", job);
}

}  // namespace

std::string BoxText(const BoundingBox& box) {
  std::string text;
  for (const Eigen::Vector3d& corner : {box.min(), box.max()}) {
    for (int axis = 0; axis < 3; ++axis)
      text += (text.empty() ? "" : ",") + NumberText(corner[axis]);
  }
  return text;
}

Site MakeSite(const std::string& scene, const SiteOptions& options) {
  const TexturedScene textured = MakeScene(scene, options.scene_seed, options.texel_scale);
  Site site;
  site.name = scene;
  site.truth = textured.mesh;
  site.model = BoundsOf(textured.Truth().model);
  // As DefaultRegion: a margin of 5 % of the width on each side.
  const double margin = 0.05 * site.model.sizes().head<2>().maxCoeff();
  site.region = BoundingBox(site.model.min().array() - margin, site.model.max().array() + margin);
  return site;
}

FlightModels MakeFlightModels(const Site& site, const std::vector<PlannedView>& views,
                              const fs::path& folder, const SiteOptions& options,
                              const JobControl& job) {
  WritePoseList(views, folder / "views.txt");
  RenderPhotos(site, folder, options, job);
  MapPhotos(folder, job);
  const std::string poses = options.true_poses ? "true" : "sfm";
  const fs::path models = folder / (poses + "_poses");
  FlightModels result{models / "sparse",
                      models / "fused.ply",
                      models / "surface.ply",
                      models / ("dense_" + std::to_string(options.dense_width_px)) / "surface.ply",
                      folder / "low" / "true_poses.txt",
                      static_cast<int>(views.size())};
  if (!fs::exists(result.sparse)) {
    const auto pose_of = PoseOfPhoto(ReadTruePoses(folder / "low" / "true_poses.txt"));
    WriteReconstructionBinary(
        BroughtToTruth(ReadReconstruction(folder / "sfm"), pose_of, options.true_poses),
        result.sparse);
  }
  const std::string box = BoxText(site.region);
  RunUnlessThere(result.fused,
                 {"superpixel_stereo", "--input_path", result.sparse.string(), "--image_path",
                  (folder / "low" / "images").string(), "--output_path", models.string()},
                 folder / "logs" / "stereo.log", job);
  RunUnlessThere(result.surface,
                 {"surface_reconstructor", "--input_path", result.fused.string(), "--output_path",
                  result.surface.string(), "--RegionOfInterest.box", box},
                 folder / "logs" / "surface.log", job);
  RunUnlessThere(result.dense_surface,
                 {"dense_reconstructor", "--backend", "builtin", "--input_path",
                  result.sparse.string(), "--image_path",
                  (folder / (fs::exists(folder / "full") ? "full" : "low") / "images").string(),
                  "--prior_path", (models / "dense").string(), "--output_path",
                  result.dense_surface.parent_path().string(), "--RegionOfInterest.box", box},
                 folder / "logs" / "dense.log", job);
  return result;
}

}  // namespace colmap_ext
