#include <algorithm>
#include <cmath>

#include "colmap_ext/dense/back_end.h"
#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// A depth map with less of it filled is as good as none.
constexpr double kMinValidShare = 0.01;

bool HasUsefulDepth(const fs::path& path) {
  if (!fs::exists(path)) return false;
  const DenseMap map = ReadDenseMap(path);
  const auto valid = std::count_if(map.data.begin(), map.data.end(),
                                   [](float z) { return z > 0 && std::isfinite(z); });
  return static_cast<double>(valid) >= kMinValidShare * static_cast<double>(map.data.size());
}

class ColmapBackEnd : public DenseBackEnd {
 public:
  explicit ColmapBackEnd(ColmapTool tool) : tool_(std::move(tool)) {}

  std::string Name() const override { return "colmap"; }

  std::string WhyUnavailable() const override {
    if (!tool_.run) return "there is no `colmap` program; install it or give --colmap_path";
    const bool has_cuda = tool_.help.find("with CUDA") != std::string::npos;
    if (has_cuda) return "";
    return "this `colmap` was built without CUDA, which its patch_match_stereo needs; "
           "use a build with CUDA, or --backend builtin";
  }

  OrientedPoints Reconstruct(const DenseRequest& request, const JobControl& job) override {
    const DenseWorkspace workspace{request.workspace_path};
    const PhotoSet& photos = request.photos->photo_set();
    PrepareDenseWorkspace(*request.photos, {}, workspace, {}, job);
    RequireWritableFolder(workspace.logs(), "log folder");
    const std::string folder = workspace.folder.string();
    job.Info("colmap patch_match_stereo (maps that are there are kept)");
    tool_.run("patch_match_stereo",
              {{"workspace_path", folder},
               {"workspace_format", "COLMAP"},
               {"PatchMatchStereo.geom_consistency", "true"}},
              workspace.logs() / "patch_match_stereo.log", job);
    CheckDepthMaps(photos, workspace);
    const fs::path fused = workspace.folder / "fused.ply";
    fs::remove(fused);
    job.Info("colmap stereo_fusion");
    tool_.run("stereo_fusion",
              {{"workspace_path", folder},
               {"workspace_format", "COLMAP"},
               {"input_type", "geometric"},
               {"output_path", fused.string()}},
              workspace.logs() / "stereo_fusion.log", job);
    RequireFile(fused, "cloud of `colmap stereo_fusion` (see logs/stereo_fusion.log)");
    OrientedPoints points = ReadOrientedPoints(fused);
    CheckCloud(points, photos, "`colmap stereo_fusion`");
    if (!request.region.isEmpty()) {
      std::erase_if(points, [&](const OrientedPoint& point) {
        return !request.region.contains(point.position);
      });
    }
    return points;
  }

 private:
  static void CheckDepthMaps(const PhotoSet& photos, const DenseWorkspace& workspace) {
    std::size_t useful = 0;
    for (const PosedPhoto& photo : photos.photos) {
      useful += HasUsefulDepth(workspace.depth_map(photo.name)) ? 1U : 0U;
    }
    if (2 * useful < photos.photos.size()) {
      throw Error("`colmap patch_match_stereo` made useful depth maps for only " +
                  std::to_string(useful) + " of " + std::to_string(photos.photos.size()) +
                  " photos; see " + (workspace.logs() / "patch_match_stereo.log").string());
    }
  }

  ColmapTool tool_;
};

}  // namespace

std::unique_ptr<DenseBackEnd> MakeColmapBackEnd(ColmapTool tool) {
  return std::make_unique<ColmapBackEnd>(std::move(tool));
}

}  // namespace colmap_ext
