#include <atomic>
#include <iostream>

#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/photo_picture.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

struct SuperpixelSegmenterPaths {
  std::filesystem::path workspace;
  std::filesystem::path images;
  std::filesystem::path output;
};

void CompletePaths(SuperpixelSegmenterPaths* paths) {
  if (!paths->workspace.empty()) {
    RequireFolder(paths->workspace, "workspace");
    const Workspace workspace(paths->workspace);
    if (paths->images.empty()) paths->images = workspace.images();
    if (paths->output.empty()) paths->output = workspace.root() / "superpixels";
  }
  RequireOption(paths->images, "image_path");
  RequireOption(paths->output, "output_path");
}

// Photos below the folder, or the one file.
std::vector<std::string> FindPhotos(std::filesystem::path* image_path) {
  if (std::filesystem::is_regular_file(*image_path)) {
    const std::string name = image_path->filename().string();
    *image_path = image_path->parent_path();
    return {name};
  }
  RequireFolder(*image_path, "image folder");
  const std::vector<std::string> names = ListPhotos(*image_path);
  if (names.empty()) throw Error("no photos (.jpg .png .tif) below " + image_path->string());
  return names;
}

void WriteImageMesh(const ImageMesh& mesh, const std::filesystem::path& path) {
  TriangleMesh flat;  // x, y in pixels (y down), z = 0
  for (const Eigen::Vector2d& p : mesh.vertices_px) flat.vertices.emplace_back(p.x(), p.y(), 0.0);
  flat.faces = mesh.triangles;
  WriteMesh(flat, path);
}

}  // namespace

int RunSuperpixelSegmenter(const Arguments& arguments, Program& program) {
  CommandLine line(
      "superpixel_segmenter",
      "Splits photos into convex polygons that follow their line segments, and these into "
      "triangles. Writes <name>.png (the mesh over the photo) and <name>.ply (vertices in "
      "pixels).");
  SuperpixelSegmenterPaths paths;
  SuperpixelOptions options;
  line.options().Add("", "workspace_path", &paths.workspace,
                     "session: reads its images, writes superpixels/");
  line.options().Add("", "image_path", &paths.images, "folder of photos, or one photo");
  line.options().Add("", "output_path", &paths.output, "folder for the results");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  ThrowIfInvalid(options.Check());
  CompletePaths(&paths);
  const std::vector<std::string> names = FindPhotos(&paths.images);
  RequireWritableFolder(paths.output, "output folder");

  const JobControl job = program.Job();
  std::atomic<std::size_t> done = 0;
  std::vector<int> num_superpixels(names.size());
  ParallelFor(names.size(), [&](std::size_t i) {
    job.ThrowIfCancelled();
    const cv::Mat photo = ReadPhoto((paths.images / names[i]).string());
    const ImageMesh mesh = SegmentPhoto(photo, options);
    num_superpixels[i] = mesh.num_superpixels;
    WriteImageMesh(mesh, paths.output / (names[i] + ".ply"));
    WritePng(DrawSuperpixels(photo, mesh), paths.output / (names[i] + ".png"));
    job.Progress("superpixels", ++done, names.size());
  });
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::cout << names[i] << ": " << num_superpixels[i] << " superpixels\n";
  }
  program.log.Result({{"photos", names.size()}, {"output_path", paths.output.string()}});
  return 0;
}

}  // namespace colmap_ext
