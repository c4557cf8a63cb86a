#include "colmap_ext/dense/back_end.h"
#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInterface = "InterfaceCOLMAP";
constexpr const char* kDensify = "DensifyPointCloud";

class OpenMvsBackEnd : public DenseBackEnd {
 public:
  std::string Name() const override { return "openmvs"; }

  std::string WhyUnavailable() const override {
    for (const char* program : {kInterface, kDensify}) {
      if (FindProgram(program).empty()) {
        return std::string("OpenMVS' program ") + program + " is not on the PATH";
      }
    }
    return "";
  }

  OrientedPoints Reconstruct(const DenseRequest& request, const JobControl& job) override {
    const DenseWorkspace workspace{request.workspace_path};
    PrepareDenseWorkspace(*request.photos, {}, workspace, {}, job);
    const fs::path folder = workspace.folder / "openmvs";
    RequireWritableFolder(folder, "OpenMVS' folder");
    const fs::path scene = folder / "scene.mvs";
    const fs::path cloud = folder / "scene_dense.ply";
    fs::remove(scene);
    fs::remove(cloud);
    Run({kInterface, "-w", folder.string(), "-i", workspace.folder.string() + "/", "-o",
         scene.string(), "--image-folder", workspace.images().string()},
        workspace, job);
    RequireNotEmpty(scene, kInterface, workspace);
    Run({kDensify, "-w", folder.string(), "-i", scene.string(), "-o",
         (folder / "scene_dense.mvs").string(), "--estimate-normals", "2"},
        workspace, job);
    RequireNotEmpty(cloud, kDensify, workspace);
    OrientedPoints points = ReadOrientedPoints(cloud);
    CheckCloud(points, request.photos->photo_set(), kDensify);
    if (!request.region.isEmpty()) {
      std::erase_if(points, [&](const OrientedPoint& point) {
        return !request.region.contains(point.position);
      });
    }
    return points;
  }

 private:
  static fs::path LogOf(const std::string& program, const DenseWorkspace& workspace) {
    return workspace.logs() / (program + ".log");
  }

  static void Run(const std::vector<std::string>& arguments, const DenseWorkspace& workspace,
                  const JobControl& job) {
    ChildProcessOptions options;
    options.arguments = arguments;
    options.log_path = LogOf(arguments[0], workspace);
    RequireWritableFolder(workspace.logs(), "log folder");
    job.Info("OpenMVS " + arguments[0]);
    const ChildProcessResult result = RunChildProcess(options, job);
    if (result.exit_code != 0) {
      throw Error(arguments[0] + " failed with exit code " + std::to_string(result.exit_code) +
                  "; full output: " + options.log_path.string());
    }
  }

  static void RequireNotEmpty(const fs::path& path, const std::string& program,
                              const DenseWorkspace& workspace) {
    if (fs::exists(path) && fs::file_size(path) > 0) return;
    throw Error(program + " ended without an error, but wrote no " + path.string() +
                "; full output: " + LogOf(program, workspace).string());
  }
};

}  // namespace

std::unique_ptr<DenseBackEnd> MakeOpenMvsBackEnd() { return std::make_unique<OpenMvsBackEnd>(); }

}  // namespace colmap_ext
