// scene_renderer: photos of a simulated scene from given poses, with depth and true poses.
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/scene_views.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct SceneRendererOptions {
  std::string scene;
  fs::path scene_path, pose_list_path, output_path, write_scene_path;
  std::uint64_t scene_seed = 1;
  double texel_scale = 1;
  bool add_ground = true, depth = false, preview = false, full_resolution = false;
  SimulatedCameraOptions camera;
  RenderOptions render;
};

void AddOptions(SceneRendererOptions* o, OptionSet* set) {
  set->Add("", "scene", &o->scene, "scene made by procedure: church, boxes or gate");
  set->Add("", "scene_path", &o->scene_path, "or a textured model (OBJ, glTF, COLLADA, …)");
  set->Add("", "scene_seed", &o->scene_seed, "of procedural scenes and added ground");
  set->Add("", "texel_scale", &o->texel_scale,
           "above 1: coarser, quicker textures for procedural scenes ([0.5, 16])");
  set->Add("", "add_ground", &o->add_ground, "lay ground under a model from a file (0 or 1)");
  set->Add("", "pose_list_path", &o->pose_list_path,
           "views to render: name x y z yaw_deg pitch_deg, a line each");
  set->Add("", "preview", &o->preview, "render overview pictures, without a pose list (0 or 1)");
  set->Add("", "output_path", &o->output_path,
           "folder for images/, true_poses.txt, sparse/ (the true poses as a COLMAP model)");
  set->Add("", "depth", &o->depth,
           "also write stereo/depth_maps/ (COLMAP's format) and depth_previews/ (0 or 1)");
  set->Add("", "full_resolution", &o->full_resolution,
           "render at Simulation.full_width x full_height (0 or 1)");
  set->Add("", "write_scene_path", &o->write_scene_path,
           "folder to write the scene into as OBJ, MTL and PNG");
  BindOptions(*set, &o->camera);
  BindOptions(*set, &o->render);
}

void CheckOptions(const SceneRendererOptions& o) {
  if (o.scene.empty() == o.scene_path.empty()) {
    throw UsageError("give either --scene or --scene_path");
  }
  const bool renders = o.preview || !o.pose_list_path.empty();
  if (o.preview && !o.pose_list_path.empty()) {
    throw UsageError("--preview and --pose_list_path exclude each other");
  }
  if (!renders && o.write_scene_path.empty()) {
    throw UsageError("nothing to do; give --pose_list_path, --preview 1 or --write_scene_path");
  }
  if (renders) RequireOption(o.output_path, "output_path");
  ThrowIfInvalid(o.camera.Check());
  ThrowIfInvalid(o.render.Check());
}

TexturedScene OpenScene(const SceneRendererOptions& o, const JobControl& job) {
  if (!o.scene.empty()) return MakeScene(o.scene, o.scene_seed, o.texel_scale);
  LoadSceneOptions load;
  load.add_ground = o.add_ground;
  load.seed = o.scene_seed;
  return LoadScene(o.scene_path, load, job);
}

// Near is bright and far is dark, nothing is black.
cv::Mat DepthPicture(const cv::Mat& depth) {
  const cv::Mat valid = depth > 0;
  double nearest = 0, farthest = 0;
  cv::minMaxLoc(depth, &nearest, &farthest, nullptr, nullptr, valid);
  cv::Mat inverse, scaled, colored;
  cv::divide(1.0, depth, inverse);
  const double low = farthest > 0 ? 1 / farthest : 0, high = nearest > 0 ? 1 / nearest : 1;
  const double range = std::max(high - low, 1e-9);
  inverse.convertTo(scaled, CV_8U, 255 / range, -255 * low / range);
  cv::applyColorMap(scaled, colored, cv::COLORMAP_TURBO);
  colored.setTo(cv::Scalar::all(0), ~valid);
  return colored;
}

void WriteDepth(const cv::Mat& depth, const std::string& name, const fs::path& folder) {
  DenseMap map(depth.cols, depth.rows, 1);
  std::copy(depth.begin<float>(), depth.end<float>(), map.data.begin());
  WriteDenseMap(map, folder / "stereo" / "depth_maps" / (name + ".geometric.bin"));
  std::vector<unsigned char> png;
  cv::imencode(".png", DepthPicture(depth), png);
  WriteFileAtomically(folder / "depth_previews" / (name + ".png"),
                      std::string(png.begin(), png.end()));
}

// The true poses as a model without points, for COLMAP's GUI.
void WriteModel(const std::vector<TruePose>& poses, const PinholeCamera& camera,
                const fs::path& folder) {
  Reconstruction model;
  model.cameras[1] = ToCamera(camera);
  for (const TruePose& pose : poses) {
    SparseImage image;
    image.name = pose.name;
    image.camera_id = 1;
    image.cam_from_world = pose.cam_from_world;
    model.images[static_cast<ImageId>(model.images.size() + 1)] = image;
  }
  WriteReconstructionText(model, folder);
}

void RenderViews(const std::vector<NamedView>& views, const TexturedScene& scene,
                 const SceneRendererOptions& o, const JobControl& job) {
  RequireWritableFolder(o.output_path, "output folder");
  const Renderer renderer(scene, o.render);
  const SimulatedCamera camera(renderer, scene.origin, o.camera);
  const PhotoResolution resolution =
      o.full_resolution ? PhotoResolution::kFull : PhotoResolution::kLow;
  std::vector<TruePose> poses;
  PinholeCamera intrinsics;
  for (std::size_t i = 0; i < views.size(); ++i) {
    job.ThrowIfCancelled();
    job.Progress("rendering", i, views.size());
    const NamedView& named = views[i];
    const CapturedPhoto photo =
        camera.CapturePhoto(named.view, o.output_path / "images" / named.name, resolution);
    poses.push_back({named.name, photo.cam_from_world});
    intrinsics = photo.camera;
    if (o.depth) {
      WriteDepth(renderer.RenderDepth(photo.camera, photo.cam_from_world), named.name,
                 o.output_path);
    }
  }
  job.Progress("rendering", views.size(), views.size());
  WriteTruePoses(poses, o.output_path / "true_poses.txt");
  WriteModel(poses, intrinsics, o.output_path / "sparse");
}

}  // namespace

int RunSceneRenderer(const Arguments& arguments, Program& program) {
  SceneRendererOptions options;
  CommandLine line("scene_renderer",
                   "Renders photos of a simulated scene, with GPS in their EXIF and exact truth.");
  AddOptions(&options, &line.options());
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckOptions(options);
  const JobControl job = program.Job();

  std::vector<NamedView> views;
  if (!options.pose_list_path.empty()) views = ReadPoseList(options.pose_list_path);
  const TexturedScene scene = OpenScene(options, job);
  job.Info("the scene has " + std::to_string(scene.mesh.faces.size()) + " triangles");
  if (options.preview) views = OverviewOf(scene);
  if (!options.write_scene_path.empty()) {
    const std::string name =
        options.scene.empty() ? options.scene_path.stem().string() : options.scene;
    WriteScene(scene, options.write_scene_path, name);
    job.Info("wrote " + (options.write_scene_path / (name + ".obj")).string());
  }
  if (!views.empty()) RenderViews(views, scene, options, job);
  program.log.Result({{"photos", views.size()}, {"output_path", options.output_path.string()}});
  return 0;
}

}  // namespace colmap_ext
