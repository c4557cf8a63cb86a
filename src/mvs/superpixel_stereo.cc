#include "colmap_ext/mvs/superpixel_stereo.h"

#include <tbb/parallel_for.h>

#include <atomic>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "mvs/raster.h"

namespace colmap_ext {
namespace {

void RequirePixels(const PhotoSet& photos) {
  for (const PosedPhoto& photo : photos.photos) {
    if (photo.bgr.cols != photo.camera.width || photo.bgr.rows != photo.camera.height ||
        photo.bgr.empty()) {
      throw Error("superpixel stereo: photo " + photo.name +
                  " has no pixels or not the size of its camera");
    }
  }
}

// Calls work(i) for each photo in parallel, with progress.
template <typename Work>
void ForEachPhoto(std::size_t count, const char* stage, const JobControl& job, const Work& work) {
  std::atomic<std::size_t> done = 0;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    job.ThrowIfCancelled();
    work(i);
    job.Progress(stage, ++done, count);
  });
}

}  // namespace

SuperpixelStereoResult RunSuperpixelStereo(const PhotoSet& photos,
                                           const SuperpixelOptions& superpixel_options,
                                           const SuperpixelStereoOptions& options,
                                           const JobControl& job) {
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(options.Check());
  RequirePixels(photos);
  const std::size_t count = photos.photos.size();
  SuperpixelStereoResult result;

  // Over-segmentation into polygons, split into triangles.
  const StageTimer superpixel_timer;
  std::vector<ImageMesh> partitions(count);
  ForEachPhoto(count, "superpixels", job, [&](std::size_t i) {
    partitions[i] = SegmentPhoto(photos.photos[i].bgr, superpixel_options);
  });
  result.superpixels = superpixel_timer.Stop();

  // Initialization: each view alone, without the fusion term.
  const StageTimer stereo_timer;
  result.neighbors = FindNeighbors(photos, options);
  const std::vector<std::vector<int>> points = PointsOfPhotos(photos);
  result.views.resize(count);
  std::vector<std::unique_ptr<LinearStereo>> solver_of_photo(count);
  std::vector<std::unique_ptr<ViewLookup>> lookup_of_photo(count);
  ForEachPhoto(count, "stereo", job, [&](std::size_t i) {
    const cv::Mat1i triangle_at = RasterizeTriangleIds(partitions[i], photos.photos[i].camera.width,
                                                       photos.photos[i].camera.height);
    solver_of_photo[i] = std::make_unique<LinearStereo>(photos, static_cast<int>(i), points[i],
                                                        partitions[i], triangle_at, options);
    result.views[i] = solver_of_photo[i]->initial();
    lookup_of_photo[i] = std::make_unique<ViewLookup>(result.views[i], triangle_at);
  });
  std::vector<LinearStereo> solvers;
  std::vector<ViewLookup> lookups;
  for (std::size_t i = 0; i < count; ++i) {
    solvers.push_back(std::move(*solver_of_photo[i]));
    lookups.push_back(std::move(*lookup_of_photo[i]));
  }
  result.stereo = stereo_timer.Stop();

  // Confidence evaluation and multi-view depth fusion.
  const StageTimer fusion_timer;
  EvaluateConfidence(lookups, result.neighbors, options, &result.views);
  const std::vector<std::vector<DepthRow>> extra_rows(count);  // beside those of fusion
  for (int pass = 0; pass < options.fusion_passes; ++pass) {
    FuseViews(solvers, result.neighbors, extra_rows, options, job, &lookups, &result.views);
    job.Progress("fusion", static_cast<std::size_t>(pass) + 1,
                 static_cast<std::size_t>(options.fusion_passes));
  }
  result.fusion = fusion_timer.Stop();
  return result;
}

}  // namespace colmap_ext
