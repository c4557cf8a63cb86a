#include "session/disk_need.h"

#include <algorithm>
#include <limits>

#include "colmap_ext/util/disk_space.h"

namespace colmap_ext {
namespace {

// Measured on the church, 148 photos of 640 x 368 px in 8 iterations, and rounded up.
constexpr double kJpegBytesPerPixel = 0.6;
constexpr double kDatabaseBytesPerPixel = 1.0;      // features and matches
constexpr double kDatabaseBytesPerFeature = 400;    // at most
constexpr double kIterationBytes = 20e6;            // surface, coverage map, pictures
constexpr double kIterationBytesPerPhoto = 0.35e6;  // points, models; at 640 px
constexpr double kMeshBytesPerPhoto = 0.4e6;        // of a photo that is solved; at 640 px
constexpr int kSolvedByNew = 4;  // photos that are solved when one is new; measured: 2 to 3
constexpr double kDenseBytesPerPhoto = 5e6;  // --Session.dense_output; at 640 px
constexpr double kReportBytes = 5e6;
constexpr double kReportBytesPerPhoto = 0.2e6;
constexpr double kReferenceWidthPx = 640;

// A person's photos are at least as wide as the dense stages use them.
double DenseScale(const StageOptions& options, bool is_simulation) {
  double width_px = options.session.max_image_size_px;
  if (is_simulation) width_px = std::min<double>(width_px, options.simulation.LowCamera().width);
  return std::max(1.0, (width_px / kReferenceWidthPx) * (width_px / kReferenceWidthPx));
}

double Pixels(const PinholeCamera& camera) {
  return static_cast<double>(camera.width) * camera.height;
}

// Of a photo that is new.
double NewPhotoBytes(const StageOptions& options, bool is_simulation) {
  const double most = kDatabaseBytesPerFeature * options.sparse.max_num_features;
  double bytes = kReportBytesPerPhoto;
  if (!is_simulation) return bytes + most;
  const double pixels = Pixels(options.simulation.LowCamera());
  bytes += kJpegBytesPerPixel * pixels + std::min(most, kDatabaseBytesPerPixel * pixels);
  if (options.session.full_resolution) {
    bytes += kJpegBytesPerPixel * Pixels(options.simulation.FullCamera());
  }
  return bytes;
}

// Of an iteration over `photos`, of which `new_photos` are new.
double IterationBytes(const StageOptions& options, bool is_simulation, int photos, int new_photos) {
  double bytes = kIterationBytesPerPhoto * photos;
  bytes += kMeshBytesPerPhoto * std::min(photos, kSolvedByNew * new_photos);
  if (options.session.dense_output) bytes += kDenseBytesPerPhoto * photos;
  return kIterationBytes + kReportBytes + DenseScale(options, is_simulation) * bytes;
}

}  // namespace

DiskNeed EstimateDiskNeed(const StageOptions& options, bool is_simulation, int photos,
                          int new_photos, int iterations_done) {
  const int all = photos + new_photos;
  const double next = new_photos * NewPhotoBytes(options, is_simulation) +
                      IterationBytes(options, is_simulation, all, new_photos);
  double session = next;
  if (is_simulation) {
    const int more_iterations = std::max(0, options.session.max_iterations - iterations_done - 1);
    const int more_photos = std::max(0, options.session.max_photos - all);
    session += more_photos * NewPhotoBytes(options, is_simulation);
    for (int i = 1; i <= more_iterations; ++i) {
      session += IterationBytes(options, is_simulation, all + more_photos * i / more_iterations,
                                more_photos / more_iterations);
    }
  }
  return {static_cast<std::uint64_t>(next), static_cast<std::uint64_t>(session)};
}

std::string DiskComplaint(const DiskNeed& need, std::uint64_t free_bytes,
                          const std::filesystem::path& workspace) {
  return DiskSpaceComplaint(workspace, "the next iteration", need.next_bytes, free_bytes);
}

std::string DiskWarning(const DiskNeed& need, std::uint64_t free_bytes,
                        const std::filesystem::path& workspace) {
  if (free_bytes >= need.session_bytes) return "";
  return workspace.string() +
         ": the disk may become full: a session up to its limits needs about " +
         BytesText(need.session_bytes) + ", " + BytesText(free_bytes) + " are free";
}

}  // namespace colmap_ext
