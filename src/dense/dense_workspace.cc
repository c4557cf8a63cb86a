#include "colmap_ext/dense/dense_workspace.h"

#include <atomic>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 98;

std::string PatchMatchConfig(const PhotoSet& photos,
                             const std::vector<std::vector<int>>& partners) {
  std::ostringstream text;
  for (std::size_t i = 0; i < photos.photos.size(); ++i) {
    if (partners.empty()) {
      text << photos.photos[i].name << "\n__auto__, 20\n";
      continue;
    }
    if (partners[i].empty()) continue;
    text << photos.photos[i].name << '\n';
    const char* separator = "";
    for (const int j : partners[i]) {
      text << separator << photos.photos[static_cast<std::size_t>(j)].name;
      separator = ", ";
    }
    text << '\n';
  }
  return text.str();
}

}  // namespace

fs::path DenseWorkspace::depth_map(const std::string& name, const std::string& type) const {
  return stereo() / "depth_maps" / (name + "." + type + ".bin");
}
fs::path DenseWorkspace::normal_map(const std::string& name) const {
  return stereo() / "normal_maps" / (name + ".geometric.bin");
}
fs::path DenseWorkspace::confidence_map(const std::string& name) const {
  return stereo() / "confidence_maps" / (name + ".bin");
}

void PrepareDenseWorkspace(const PhotoSource& photos, const std::vector<std::vector<int>>& partners,
                           const DenseWorkspace& workspace, const JobRank& rank,
                           const JobControl& job) {
  const std::vector<PosedPhoto>& posed = photos.photo_set().photos;
  std::atomic<std::size_t> done = 0;
  ParallelFor(posed.size(), [&](std::size_t i) {
    if (job.IsCancelled() || !rank.IsMine(i)) return;
    const fs::path path = workspace.images() / posed[i].name;
    if (!fs::exists(path)) WritePhoto(photos.Load(i), path, kJpegQuality);
    job.Progress("undistorting", ++done, posed.size());
  });
  job.ThrowIfCancelled();
  if (!rank.IsFirst()) return;
  WriteReconstructionBinary(photos.PinholeModel(), workspace.sparse());
  std::ostringstream names;
  for (const PosedPhoto& photo : posed) names << photo.name << '\n';
  WriteFileAtomically(workspace.stereo() / "fusion.cfg", names.str());
  WriteFileAtomically(workspace.stereo() / "patch-match.cfg",
                      PatchMatchConfig(photos.photo_set(), partners));
}

cv::Mat MatOf(const DenseMap& map) {
  std::vector<cv::Mat> channels;
  const std::size_t size =
      static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  for (int c = 0; c < map.channels; ++c) {
    // cv::Mat does not write to it: merge copies.
    auto* begin = const_cast<float*>(map.data.data() + static_cast<std::size_t>(c) * size);
    channels.emplace_back(map.height, map.width, CV_32F, begin);
  }
  cv::Mat mat;
  cv::merge(channels, mat);
  return mat;
}

DenseMap MapOf(const cv::Mat& mat) {
  DenseMap map(mat.cols, mat.rows, mat.channels());
  std::vector<cv::Mat> channels;
  cv::split(mat, channels);
  auto out = map.data.begin();
  for (const cv::Mat& channel : channels) {
    out = std::copy(channel.begin<float>(), channel.end<float>(), out);
  }
  return map;
}

}  // namespace colmap_ext
