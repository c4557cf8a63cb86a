#include "report/page_photos.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <vector>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "scene/undistort.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 80;

bool IsFresh(const fs::path& target, const fs::path& source) {
  std::error_code error;
  const bool is_newer = fs::is_regular_file(target, error) &&
                        fs::last_write_time(target, error) >= fs::last_write_time(source, error);
  return is_newer && !error;
}

// The same lens for photos of another width.
Camera Scaled(const Camera& camera, double ratio) {
  Camera scaled = camera;
  scaled.width = static_cast<int>(std::lround(camera.width * ratio));
  scaled.height = static_cast<int>(std::lround(camera.height * ratio));
  const auto in_pixels = static_cast<std::size_t>(NumFocalParams(camera.model) + 2);
  for (std::size_t i = 0; i < in_pixels; ++i) scaled.params[i] *= ratio;
  return scaled;
}

struct ShownCamera {
  cv::Size size;
  cv::Mat undistort;  // empty: a pinhole
};

ShownCamera ShownCameraOf(const Camera& camera, int width_px) {
  const double ratio = std::min(1.0, static_cast<double>(width_px) / camera.width);
  const Camera scaled = Scaled(camera, ratio);
  ShownCamera shown{{scaled.width, scaled.height}, {}};
  if (!IsPinhole(camera)) {
    shown.undistort =
        BuildUndistortMap(scaled, ScaleTo(ToPinhole(camera), scaled.width, scaled.height));
  }
  return shown;
}

void WritePhotoForPage(const fs::path& source, const ShownCamera& camera, const fs::path& target) {
  const cv::Mat photo = ReadPhoto(source.string());
  cv::Mat small;
  cv::resize(photo, small, camera.size, 0, 0, cv::INTER_AREA);
  if (!camera.undistort.empty()) small = Undistort(small, camera.undistort);
  WritePhoto(small, target, kJpegQuality);
}

}  // namespace

std::string PagePhotoFolder(int width_px) { return "photos_" + std::to_string(width_px); }

fs::path PhotoFolderOfWorkspace(const Workspace& workspace) {
  if (!fs::exists(workspace.state_json())) return workspace.images();
  const Json state = ReadJsonFile(workspace.state_json());
  const std::string source = JsonNode(state, workspace.state_json())["source"].Text();
  const std::string prefix = "photos ";
  return source.starts_with(prefix) ? fs::path(source.substr(prefix.size())) : workspace.images();
}

void WritePagePhotos(const Workspace& workspace, const fs::path& image_path, int width_px,
                     const fs::path& folder, const JobControl& job) {
  const auto latest = workspace.LatestIteration();
  if (!latest) return;
  const Reconstruction model =
      ReadReconstruction(IterationFiles{workspace.iteration(*latest)}.sparse());
  std::map<CameraId, ShownCamera> cameras;
  for (const auto& [id, camera] : model.cameras) cameras[id] = ShownCameraOf(camera, width_px);
  std::vector<const SparseImage*> images;
  for (const auto& [id, image] : model.images) images.push_back(&image);
  std::vector<std::string> problems(images.size());
  ParallelFor(images.size(), [&](std::size_t i) {
    if (job.IsCancelled()) return;
    const fs::path source = image_path / images[i]->name;
    const fs::path target = folder / PagePhotoFolder(width_px) / (images[i]->name + ".jpg");
    if (IsFresh(target, source)) return;
    try {
      WritePhotoForPage(source, cameras.at(images[i]->camera_id), target);
    } catch (const Error& error) {
      problems[i] = error.what();
    }
  });
  job.ThrowIfCancelled();
  const auto count = std::count_if(problems.begin(), problems.end(),
                                   [](const std::string& text) { return !text.empty(); });
  if (count == 0) return;
  const auto first = std::find_if(problems.begin(), problems.end(),
                                  [](const std::string& text) { return !text.empty(); });
  job.Warn("the page lacks " + std::to_string(count) + " photos; the first: " + *first);
}

}  // namespace colmap_ext
