#include "planning_inputs.h"

#include <limits>

#include "colmap_ext/path/path_planner.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "workspace_inputs.h"

namespace colmap_ext {

PlanningInputs ReadPlanningInputs(const std::filesystem::path& sparse_path,
                                  const std::filesystem::path& mesh_path, int max_width_px) {
  RequireFolder(sparse_path, "sparse model");
  RequireFile(mesh_path, "surface");
  PlanningInputs inputs;
  inputs.frame = FrameOfModel(sparse_path);
  RequireMetric(inputs.frame);
  inputs.surface = ReadMesh(mesh_path);
  inputs.photos =
      LoadPosesOnly(sparse_path, max_width_px > 0 ? max_width_px : std::numeric_limits<int>::max());
  if (inputs.photos.photos.empty()) {
    throw Error(sparse_path.string() + ": the model has no registered photo");
  }
  return inputs;
}

Surface ConfidentSurface(const PlanningInputs& inputs, const std::filesystem::path& mesh_path,
                         const PathOptions& options, const JobControl& job) {
  if (options.confident_spacing_m > 0) {
    try {
      return ReadSurface(mesh_path);
    } catch (const Error&) {
      job.Warn(mesh_path.string() +
               " has no sample_spacing_m: all of it counts as seen with confidence");
    }
  }
  return {inputs.surface};
}

}  // namespace colmap_ext
