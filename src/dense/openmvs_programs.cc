#include "dense/openmvs_programs.h"

#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

namespace fs = std::filesystem;

std::string WhyNoOpenMvs(const std::vector<std::string>& programs) {
  for (const std::string& program : programs) {
    if (FindProgram(program).empty()) return "OpenMVS' program " + program + " is not on the PATH";
  }
  return "";
}

fs::path OpenMvsFolder(const DenseWorkspace& workspace) {
  return fs::absolute(workspace.folder) / "openmvs";
}

void RunOpenMvs(const std::string& program, const std::vector<std::string>& arguments,
                const fs::path& result, const DenseWorkspace& workspace, const JobControl& job) {
  RequireWritableFolder(OpenMvsFolder(workspace), "OpenMVS' folder");
  RequireWritableFolder(workspace.logs(), "log folder");
  fs::remove(result);
  ChildProcessOptions options;
  options.arguments = {program, "-w", OpenMvsFolder(workspace).string()};
  options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
  options.log_path = workspace.logs() / (program + ".log");
  job.Info("OpenMVS " + program);
  const ChildProcessResult child = RunChildProcess(options, job);
  const std::string log = "; full output: " + options.log_path.string();
  if (child.exit_code != 0) {
    throw Error(program + " failed with exit code " + std::to_string(child.exit_code) + log);
  }
  if (!fs::exists(result) || fs::file_size(result) == 0) {
    throw Error(program + " ended without an error, but wrote no " + result.string() + log);
  }
}

fs::path ImportIntoOpenMvs(const DenseWorkspace& workspace, const JobControl& job) {
  fs::path scene = OpenMvsFolder(workspace) / "scene.mvs";
  RunOpenMvs(kInterfaceColmap,
             {"-i", fs::absolute(workspace.folder).string() + "/", "-o", scene.string(),
              "--image-folder", fs::absolute(workspace.images()).string()},
             scene, workspace, job);
  return scene;
}

}  // namespace colmap_ext
