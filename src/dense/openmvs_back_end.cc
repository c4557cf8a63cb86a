#include "colmap_ext/dense/back_end.h"
#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "dense/openmvs_programs.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class OpenMvsBackEnd : public DenseBackEnd {
 public:
  std::string Name() const override { return "openmvs"; }

  std::string WhyUnavailable() const override {
    return WhyNoOpenMvs({kInterfaceColmap, kDensifyPointCloud});
  }

  OrientedPoints Reconstruct(const DenseRequest& request, const JobControl& job) override {
    const DenseWorkspace workspace{request.workspace_path};
    PrepareDenseWorkspace(*request.photos, {}, workspace, {}, job);
    const fs::path scene = ImportIntoOpenMvs(workspace, job);
    const fs::path cloud = OpenMvsFolder(workspace) / "scene_dense.ply";
    RunOpenMvs(kDensifyPointCloud,
               {"-i", scene.string(), "-o", fs::path(cloud).replace_extension(".mvs").string(),
                "--estimate-normals", "2"},
               cloud, workspace, job);
    OrientedPoints points = ReadOrientedPoints(cloud);
    CheckCloud(points, request.photos->photo_set(), kDensifyPointCloud);
    if (!request.region.isEmpty()) {
      std::erase_if(points, [&](const OrientedPoint& point) {
        return !request.region.contains(point.position);
      });
    }
    return points;
  }
};

}  // namespace

std::unique_ptr<DenseBackEnd> MakeOpenMvsBackEnd() { return std::make_unique<OpenMvsBackEnd>(); }

}  // namespace colmap_ext
