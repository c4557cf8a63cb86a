// dense_reconstructor: photos with poses to a dense cloud and a mesh, offline.
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <utility>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/dense/back_end.h"
#include "colmap_ext/dense/photo_source.h"
#include "colmap_ext/dense/texture.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sfm/bundle_adjustment.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/surface/poisson.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/disk_space.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/statistics.h"
#include "command_line.h"
#include "commands.h"
#include "job_options.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct DenseReconstructorOptions {
  fs::path workspace, input, images, output, prior, colmap;
  std::string backend = "auto";
  bool adjust = false, mesh = true;
  std::string texture = "auto";
  JobOptions jobs;
  DenseStereoOptions stereo;
  SurfaceOptions surface;
  RegionOptions region;
};

void AddOptions(DenseReconstructorOptions* o, OptionSet* set) {
  set->Add("", "workspace_path", &o->workspace,
           "session: its newest sparse model, images_full/ (else images/), its dense maps as the "
           "start, and dense_model/ for the result, unless given below");
  set->Add("", "input_path", &o->input, "sparse model, any camera");
  set->Add("", "image_path", &o->images,
           "folder of the model's photos; larger ones than the model's are fine");
  set->Add("", "output_path", &o->output,
           "folder for fused.ply, surface.ply and the dense workspace; a run that was stopped goes "
           "on there");
  set->Add(
      "", "prior_path", &o->prior,
      "dense workspace of superpixel_stereo: says how deep photos look; else the sparse points");
  set->Add("", "backend", &o->backend,
           "colmap (needs CUDA), openmvs (its programs on the PATH), builtin, or auto: the first "
           "of them that can be used");
  set->Add("", "colmap_path", &o->colmap, "colmap program; else the one on the PATH");
  set->Add("", "adjust", &o->adjust,
           "first refine the poses by a short bundle adjustment, intrinsics kept (0 or 1)");
  set->Add("", "mesh", &o->mesh, "make surface.ply, a Poisson mesh with vertex colours (0 or 1)");
  set->Add("", "texture", &o->texture,
           "make textured.obj from surface.ply: yes, no, or auto: where OpenMVS' InterfaceCOLMAP "
           "and TextureMesh are on the PATH");
  BindOptions(*set, &o->jobs);
  BindOptions(*set, &o->stereo);
  BindOptions(*set, &o->surface);
  BindOptions(*set, &o->region);
}

void CompletePaths(DenseReconstructorOptions* o) {
  if (!o->workspace.empty()) {
    RequireFolder(o->workspace, "workspace");
    const Workspace workspace(o->workspace);
    const IterationFiles files = LatestIterationFiles(workspace);
    const bool has_full = fs::is_directory(workspace.images_full());
    if (o->input.empty()) o->input = files.sparse();
    if (o->images.empty()) o->images = has_full ? workspace.images_full() : workspace.images();
    if (o->output.empty()) o->output = files.folder / "dense_model";
    if (o->prior.empty() && fs::is_directory(files.dense())) o->prior = files.dense();
  }
  RequireOption(o->input, "input_path");
  RequireOption(o->images, "image_path");
  RequireOption(o->output, "output_path");
  RequireFolder(o->input, "sparse model");
  RequireFolder(o->images, "image folder");
  if (!o->prior.empty()) RequireFolder(o->prior, "dense workspace");
  RequireWritableFolder(o->output, "output folder");
}

ColmapTool ColmapToolOf(const std::shared_ptr<ColmapProgram>& program) {
  ColmapTool tool;
  if (!program) return tool;
  tool.help = program->dialect().help();
  tool.run = [program](const std::string& command, const ColmapTool::Arguments& arguments,
                       const fs::path& log_path,
                       const JobControl& job) { program->Run(command, arguments, log_path, job); };
  return tool;
}

// Null when there is none and the user did not name one.
std::shared_ptr<ColmapProgram> FindColmapProgram(const DenseReconstructorOptions& o) {
  if (o.colmap.empty() && FindProgram("colmap").empty()) return nullptr;
  return std::make_shared<ColmapProgram>(o.colmap);
}

BoundingBox Grown(const BoundingBox& box, double ratio) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(ratio * box.diagonal().norm());
  return {box.min() - margin, box.max() + margin};
}

// Median distance of points that were next to each other in a photo.
double PointSpacing(const OrientedPoints& points) {
  std::vector<double> distances;
  const std::size_t step = points.size() / 20000 + 1;
  for (std::size_t i = 0; i + 1 < points.size(); i += step) {
    distances.push_back((points[i + 1].position - points[i].position).norm());
  }
  return MiddleValue(std::move(distances));
}

// A mesh as fine as the points, that closes only small holes; what the user gave stays.
SurfaceOptions SurfaceOptionsFor(const OrientedPoints& points, SurfaceOptions options) {
  constexpr double kTrimCells = 12;
  const double spacing = PointSpacing(points);
  if (options.depth == 0 && options.resolution_m == 0) options.resolution_m = spacing;
  if (options.trim_spacing_m == 0) options.trim_spacing_m = kTrimCells * spacing;
  return options;
}

void WriteSurfaceOf(const OrientedPoints& points, const RegionOfInterest& region,
                    const DenseReconstructorOptions& o, const JobControl& job) {
  const Surface surface =
      ReconstructSurface(points, region, SurfaceOptionsFor(points, o.surface), job);
  const fs::path path = o.output / "surface.ply";
  WriteSurface(surface, path);
  job.Info("surface: " + std::to_string(surface.mesh.vertices.size()) + " vertices, " +
           std::to_string(surface.mesh.faces.size()) + " faces: " + path.string());
}

// Whether textured.obj is to be made; said at once, not after hours of matching.
bool WantsTexture(const DenseReconstructorOptions& o, const JobControl& job) {
  if (o.texture != "yes" && o.texture != "no" && o.texture != "auto") {
    throw UsageError("--texture must be yes, no or auto, not " + o.texture);
  }
  if (o.texture == "yes" && !o.mesh) throw UsageError("--texture yes needs --mesh 1");
  if (o.texture == "no" || !o.mesh) return false;
  const std::string complaint = WhyNoTexture();
  if (complaint.empty()) return true;
  if (o.texture == "yes") throw Error("--texture yes: " + complaint);
  job.Debug("no texture: " + complaint);
  return false;
}

// Depth, normals, confidence and what a stopped run goes on from, then the fused cloud and its
// mesh: 20 bytes a pixel are the maps.
void RequireRoom(const PhotoSource& photos, const fs::path& output) {
  constexpr double kBytesPerPixel = 40;
  double bytes = 0;
  for (const PosedPhoto& photo : photos.photo_set().photos) {
    bytes += kBytesPerPixel * photo.camera.width * photo.camera.height;
  }
  const std::uint64_t free_bytes = FreeDiskBytes(output) + FolderBytes(output);
  const std::string complaint =
      DiskSpaceComplaint(output, "the dense model", static_cast<std::uint64_t>(bytes), free_bytes);
  if (!complaint.empty()) throw Error(complaint);
}

// Other back ends split their work themselves, and processes that adjust poses each for themselves
// may not get the same ones.
void RequireSharable(const DenseBackEnd& back_end, const DenseReconstructorOptions& o) {
  if (back_end.Name() != "builtin") {
    throw UsageError("--jobs " + o.jobs.jobs + " goes with --backend builtin, not with " +
                     back_end.Name());
  }
  if (o.adjust) {
    throw UsageError("--adjust goes with --jobs local only; adjust the model first");
  }
}

}  // namespace

int RunDenseReconstructor(const Arguments& arguments, Program& program) {
  DenseReconstructorOptions o;
  CommandLine line("dense_reconstructor",
                   "Photos with poses to a dense cloud (fused.ply) and a mesh (surface.ply), "
                   "offline. Takes any COLMAP model; photos may be larger than those the model was "
                   "made from. A run that was stopped goes on when it is started again.");
  AddOptions(&o, &line.options());
  if (!line.Parse(arguments, &program.log)) return 0;
  const JobRank rank = RankOf(o.jobs);
  ThrowIfInvalid(o.stereo.Check());
  ThrowIfInvalid(o.surface.Check());
  ThrowIfInvalid(o.region.Check());
  const JobControl job = program.Job();
  const bool wants_texture = WantsTexture(o, job);
  CompletePaths(&o);

  const std::shared_ptr<ColmapProgram> colmap = FindColmapProgram(o);
  std::vector<std::unique_ptr<DenseBackEnd>> back_ends;
  back_ends.push_back(MakeColmapBackEnd(ColmapToolOf(colmap)));
  back_ends.push_back(MakeOpenMvsBackEnd());
  back_ends.push_back(MakeBuiltinBackEnd(o.stereo));
  DenseBackEnd& back_end = ChooseBackEnd(o.backend, back_ends);
  if (rank.IsShared()) RequireSharable(back_end, o);

  const StageTimer timer;
  Reconstruction model = ReadReconstruction(o.input);
  if (o.adjust) {
    const BundleResult fit = AdjustBundle({}, {}, job, &model);
    job.Info("bundle adjustment: " + std::to_string(fit.initial_rms_px) + " to " +
             std::to_string(fit.final_rms_px) + " px RMS");
  }
  const PhotoSource photos(model, o.images, o.stereo.max_width_px);
  RequireRoom(photos, o.output);
  const WorldFrame frame = FrameOfModel(o.input);
  const RegionOfInterest region = DefaultRegion(photos.photo_set(), frame, o.region);
  job.Info("back end " + back_end.Name() + ", " + std::to_string(photos.photo_set().photos.size()) +
           " photos");
  DenseRequest request{&photos, o.output, o.prior, Grown(region.box, o.surface.crop_margin_ratio),
                       rank};
  const OrientedPoints points = back_end.Reconstruct(request, job);
  if (!rank.IsFirst()) return 0;
  WriteOrientedPoints(points, o.output / "fused.ply");
  job.Info(std::to_string(points.size()) + " points: " + (o.output / "fused.ply").string());
  if (o.mesh) WriteSurfaceOf(points, region, o, job);
  if (wants_texture) {
    const fs::path textured = o.output / "textured.obj";
    TextureSurface({o.output}, o.output / "surface.ply", textured, job);
    job.Info("textured mesh: " + textured.string());
  }
  const StageCost cost = timer.Stop();
  std::cout << photos.photo_set().photos.size() << " photos, " << points.size() << " points, "
            << cost.wall_s << " s, " << cost.cpu_s << " CPU s, peak " << cost.peak_mib << " MiB\n";
  program.log.Result({{"photos", photos.photo_set().photos.size()},
                      {"points", points.size()},
                      {"back_end", back_end.Name()},
                      {"wall_s", cost.wall_s},
                      {"cpu_s", cost.cpu_s},
                      {"peak_mib", cost.peak_mib},
                      {"output_path", o.output.string()}});
  return 0;
}

}  // namespace colmap_ext
