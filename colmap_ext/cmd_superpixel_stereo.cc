#include <iostream>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/depth_map.h"
#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_io.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/photo_picture.h"
#include "colmap_ext/report/picture_overlay.h"
#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/photo_scale.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "command_line.h"
#include "commands.h"
#include "job_options.h"

namespace colmap_ext {
namespace {

struct SuperpixelStereoPaths {
  std::filesystem::path workspace;
  std::filesystem::path sparse;
  std::filesystem::path images;
  std::filesystem::path output;
};

void CompletePaths(SuperpixelStereoPaths* paths) {
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

// Depth (near bright, far dark, by inverse depth), normal (as colour) and confidence of each photo.
void WriteMapPictures(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                      const std::filesystem::path& folder) {
  ParallelFor(views.size(), [&](std::size_t i) {
    const ViewMaps maps = RasterizeView(views[i], 0.0);
    cv::Mat1f inverse_depth(maps.depth.height, maps.depth.width, 0.0F);
    cv::Mat3b normal(maps.depth.height, maps.depth.width, cv::Vec3b(0, 0, 0));
    for (int y = 0; y < maps.depth.height; ++y) {
      for (int x = 0; x < maps.depth.width; ++x) {
        if (!(maps.depth.At(y, x) > 0)) continue;
        inverse_depth(y, x) = 1.0F / maps.depth.At(y, x);
        for (int c = 0; c < 3; ++c) {
          normal(y, x)[2 - c] =
              cv::saturate_cast<std::uint8_t>(127.5F * (1.0F - maps.normal.At(y, x, c)));
        }
      }
    }
    cv::Mat grey, depth;
    cv::normalize(inverse_depth, grey, 0, 255, cv::NORM_MINMAX, CV_8U);
    cv::applyColorMap(grey, depth, cv::COLORMAP_INFERNO);
    const std::string name = photos.photos[i].name;
    WritePng(depth, folder / (name + ".depth.png"));
    WritePng(normal, folder / (name + ".normal.png"));
    WritePng(DrawConfidence(photos.photos[i].bgr, views[i]), folder / (name + ".confidence.png"));
  });
}

// The paper's three cues of Γ as maps (dense/stereo/confidence_cues) and pictures.
void WriteCues(const PhotoSet& photos, const SuperpixelStereoResult& result,
               const SuperpixelStereoOptions& options, const IterationFiles& files) {
  std::vector<ViewLookup> lookups;
  for (const ViewMesh& view : result.views) lookups.emplace_back(view, TriangleIdMap(view));
  ParallelFor(result.views.size(), [&](std::size_t i) {
    const std::vector<ConfidenceCues> cues =
        EvaluateCues(result.views, lookups, result.neighbors[i], static_cast<int>(i), options);
    const DenseMap maps = ConfidenceCueMaps(cues, lookups[i].triangle_at, options);
    const std::string& name = photos.photos[i].name;
    WriteDenseMap(maps, files.dense() / "stereo" / "confidence_cues" / (name + ".bin"));
    int channel = 0;
    for (const char* cue : {"position", "normal", "view"}) {
      cv::Mat1b grey(maps.height, maps.width);
      for (int y = 0; y < maps.height; ++y) {
        for (int x = 0; x < maps.width; ++x) {
          grey(y, x) = cv::saturate_cast<std::uint8_t>(255.0F * maps.At(y, x, channel));
        }
      }
      cv::Mat picture;
      cv::applyColorMap(grey, picture, cv::COLORMAP_VIRIDIS);
      WritePng(picture, files.pictures() / (name + ".cue_" + cue + ".png"));
      ++channel;
    }
  });
}

// The fused mesh and the fused points, seen from above at an angle.
void WriteFusedPictures(const std::vector<ViewMesh>& views, double min_confidence,
                        const OrientedPoints& points, const std::filesystem::path& folder) {
  ColoredMesh fused;
  for (const ViewMesh& view : views) {
    const ColoredMesh part = MeshInWorld(view, min_confidence);
    const int first = static_cast<int>(fused.mesh.vertices.size());
    fused.mesh.vertices.insert(fused.mesh.vertices.end(), part.mesh.vertices.begin(),
                               part.mesh.vertices.end());
    fused.color.insert(fused.color.end(), part.color.begin(), part.color.end());
    for (const auto& face : part.mesh.faces) fused.mesh.faces.push_back(face.array() + first);
  }
  if (fused.mesh.vertices.empty()) return;
  const BoundingBox bounds = RobustBounds(fused.mesh.vertices, 0.05);
  const PictureCamera camera =
      FitCamera(bounds, {DegToRad(30.0), DegToRad(-30.0)}, cv::Size(1280, 800));
  PictureOptions flat;
  flat.shadows = false;
  const Picture mesh_picture =
      RenderMesh(fused.mesh, VertexColors(fused.mesh, fused.color), camera, flat);
  WritePng(mesh_picture.bgr, folder / "fused_mesh.png");

  Picture cloud = RenderMesh({}, ConstantColor({1, 1, 1}), camera, flat);
  std::vector<Eigen::Vector3d> positions, normals;
  std::vector<Rgb> colors;
  for (const OrientedPoint& point : points) {
    positions.push_back(point.position);
    normals.push_back(point.normal);
    colors.push_back(point.color.cast<float>() / 255.0F);
  }
  DrawDiscs(positions, normals, colors, 0.0015 * bounds.diagonal().norm(), &cloud);
  WritePng(cloud.bgr, folder / "fused_points.png");
}

}  // namespace

int RunSuperpixelStereo(const Arguments& arguments, Program& program) {
  CommandLine line(
      "superpixel_stereo",
      "Fast linear dense stereo: a mesh for each photo of a sparse model, fused over its "
      "neighbours. Writes meshes/<name>.ply, fused.ply (points), fused_mesh.ply and dense/, a "
      "workspace for `colmap stereo_fusion`.");
  SuperpixelStereoPaths paths;
  int max_width_px = 640;
  bool pictures = false;
  SuperpixelOptions superpixel_options;
  SuperpixelStereoOptions stereo_options;
  PointSamplerOptions point_options;
  JobOptions job_options;
  line.options().Add("", "workspace_path", &paths.workspace,
                     "session: works on its latest iteration");
  line.options().Add("", "input_path", &paths.sparse, "sparse model");
  line.options().Add("", "image_path", &paths.images, "folder of the model's photos");
  line.options().Add("", "output_path", &paths.output, "folder for the results");
  line.options().Add("", "max_width_px", &max_width_px,
                     "wider photos are scaled down to this width (px, at least 64); larger "
                     "than the photos for their full resolution");
  line.options().Add(
      "", "pictures", &pictures,
      "also write pictures of depth, normals, confidence and its cues, fused mesh and points, "
      "and the cues as maps");
  BindOptions(line.options(), &job_options);
  BindOptions(line.options(), &superpixel_options);
  BindOptions(line.options(), &stereo_options);
  BindOptions(line.options(), &point_options);
  if (!line.Parse(arguments, &program.log)) return 0;
  if (max_width_px < 64) throw UsageError("--max_width_px must be at least 64");
  const JobRank rank = RankOf(job_options);
  if (rank.IsShared() && pictures) throw UsageError("--pictures goes with --jobs local only");
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(stereo_options.Check());
  ThrowIfInvalid(point_options.Check());
  CompletePaths(&paths);
  RequireFolder(paths.sparse, "sparse model");
  RequireFolder(paths.images, "image folder");
  RequireWritableFolder(paths.output, "output folder");

  const JobControl job = program.Job();
  const Reconstruction model = ReadReconstruction(paths.sparse);
  PhotoSet photos = LoadPhotoSet(model, "", false);
  DownscalePhotos(max_width_px, &photos);
  const std::vector<std::uint8_t> all(photos.photos.size(), 1);
  LoadPixels(model, paths.images.string(), all, &photos.photos);
  const IterationFiles files{paths.output};
  std::optional<PhotoExchange> exchange;
  if (rank.IsShared()) {
    exchange.emplace(photos, superpixel_options, stereo_options, paths.output / "jobs", rank);
  }
  const SuperpixelStereoResult result =
      exchange ? ShareSuperpixelStereo(photos, superpixel_options, stereo_options, job, &*exchange)
               : RunSuperpixelStereo(photos, superpixel_options, stereo_options, job);
  job.ThrowIfCancelled();

  WriteViewMeshes(photos, result.views, point_options.min_confidence, files.meshes(), rank);
  WriteDenseWorkspace(photos, model, result.views, result.neighbors, 0.0, files.dense(), rank);
  if (exchange) exchange->Finish(job);
  if (!rank.IsFirst()) return 0;
  const OrientedPoints points = SamplePoints(photos, result.views, result.neighbors, point_options);
  WriteOrientedPoints(points, files.fused_ply());
  WriteFusedMesh(result.views, point_options.min_confidence, paths.output / "fused_mesh.ply");
  if (pictures) {
    WriteMapPictures(photos, result.views, files.pictures());
    WriteCues(photos, result, stereo_options, files);
    WriteFusedPictures(result.views, point_options.min_confidence, points, files.pictures());
  }
  std::cout << photos.photos.size() << " photos, "
            << static_cast<int>(100 * ConfidentShare(result.views, point_options.min_confidence))
            << " % of facets confident, " << points.size() << " points; CPU seconds: superpixels "
            << result.superpixels.cpu_s << ", stereo " << result.stereo.cpu_s << ", fusion "
            << result.fusion.cpu_s << '\n';
  program.log.Result(
      {{"photos", photos.photos.size()},
       {"points", points.size()},
       {"confident_share", ConfidentShare(result.views, point_options.min_confidence)},
       {"output_path", paths.output.string()}});
  return 0;
}

}  // namespace colmap_ext
