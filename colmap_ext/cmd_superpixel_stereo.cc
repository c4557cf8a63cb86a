#include <iostream>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_io.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/photo_scale.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

struct Paths {
  std::filesystem::path workspace;
  std::filesystem::path sparse;
  std::filesystem::path images;
  std::filesystem::path output;
};

void CompletePaths(Paths* paths) {
  if (!paths->workspace.empty()) {
    RequireFolder(paths->workspace, "workspace");
    const Workspace workspace(paths->workspace);
    const std::optional<int> iteration = workspace.LatestIteration();
    if (!iteration && paths->sparse.empty()) {
      throw Error("workspace " + paths->workspace.string() +
                  " has no sparse model yet; run sparse_updater first");
    }
    const IterationFiles files{workspace.iteration(iteration.value_or(0))};
    if (paths->sparse.empty()) paths->sparse = files.sparse();
    if (paths->images.empty()) paths->images = workspace.images();
    if (paths->output.empty()) paths->output = files.folder;
  }
  RequireOption(paths->sparse, "input_path");
  RequireOption(paths->images, "image_path");
  RequireOption(paths->output, "output_path");
}

double ConfidentShare(const std::vector<ViewMesh>& views, double min_confidence) {
  std::size_t all = 0;
  std::size_t confident = 0;
  for (const ViewMesh& view : views) {
    all += view.confidence.size();
    for (const float confidence : view.confidence) confident += confidence > min_confidence;
  }
  return all == 0 ? 0 : static_cast<double>(confident) / static_cast<double>(all);
}

}  // namespace

int RunSuperpixelStereo(const Arguments& arguments, const CancelFlag& cancel) {
  CommandLine line(
      "superpixel_stereo",
      "Fast linear dense stereo: a mesh for each photo of a sparse model, fused over its "
      "neighbours. Writes meshes/<name>.ply, fused.ply and dense/, a workspace for "
      "`colmap stereo_fusion`.");
  Paths paths;
  int max_width_px = 640;
  SuperpixelOptions superpixel_options;
  SuperpixelStereoOptions stereo_options;
  PointSamplerOptions point_options;
  line.options().Add("", "workspace_path", &paths.workspace,
                     "session: works on its latest iteration");
  line.options().Add("", "input_path", &paths.sparse, "sparse model");
  line.options().Add("", "image_path", &paths.images, "folder of the model's photos");
  line.options().Add("", "output_path", &paths.output, "folder for the results");
  line.options().Add("", "max_width_px", &max_width_px,
                     "wider photos are scaled down to this width (px, at least 64)");
  BindOptions(line.options(), &superpixel_options);
  BindOptions(line.options(), &stereo_options);
  BindOptions(line.options(), &point_options);
  if (!line.Parse(arguments)) return 0;
  if (max_width_px < 64) throw UsageError("--max_width_px must be at least 64");
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(stereo_options.Check());
  ThrowIfInvalid(point_options.Check());
  CompletePaths(&paths);
  RequireFolder(paths.sparse, "sparse model");
  RequireFolder(paths.images, "image folder");
  RequireWritableFolder(paths.output, "output folder");

  ConsoleSink sink(line.log_level());
  const JobControl job(&sink, &cancel);
  const Reconstruction model = ReadReconstruction(paths.sparse);
  PhotoSet photos = LoadPhotoSet(model, paths.images.string(), true);
  DownscalePhotos(max_width_px, &photos);
  const SuperpixelStereoResult result =
      RunSuperpixelStereo(photos, superpixel_options, stereo_options, job);
  const OrientedPoints points = SamplePoints(photos, result.views, point_options);
  job.ThrowIfCancelled();

  const IterationFiles files{paths.output};
  WriteViewMeshes(photos, result.views, point_options.min_confidence, files.meshes());
  WriteDenseWorkspace(photos, model, result.views, result.neighbors, 0.0, files.dense());
  WriteOrientedPoints(points, files.fused_ply());
  std::cout << photos.photos.size() << " photos, "
            << static_cast<int>(100 * ConfidentShare(result.views, point_options.min_confidence))
            << " % of facets confident, " << points.size() << " points; CPU seconds: superpixels "
            << result.superpixels.cpu_s << ", stereo " << result.stereo.cpu_s << ", fusion "
            << result.fusion.cpu_s << '\n';
  return 0;
}

}  // namespace colmap_ext
