#include "workspace_inputs.h"

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/photo_scale.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/region_json.h"
#include "colmap_ext/session/session_options.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"

namespace colmap_ext {

namespace fs = std::filesystem;

void RequireWorkspaceOrFiles(const fs::path& workspace_path, const std::vector<PathOption>& files) {
  if (workspace_path.empty()) {
    for (const PathOption& file : files) RequireOption(file.value, file.name);
    return;
  }
  std::string names;
  bool has_files = false;
  for (std::size_t i = 0; i < files.size(); ++i) {
    names += i == 0 ? "" : i + 1 == files.size() ? " and " : ", ";
    names += std::string("--") + files[i].name;
    has_files = has_files || !files[i].value.empty();
  }
  if (has_files) throw UsageError("give either --workspace_path, or " + names);
  RequireFolder(workspace_path, "workspace");
}

IterationFiles LatestIterationFiles(const Workspace& workspace) {
  const std::optional<int> latest = workspace.LatestIteration();
  if (!latest) {
    throw Error(workspace.root().string() +
                ": no iteration with a sparse model; run active_capture or sparse_updater first");
  }
  return {workspace.iteration(*latest)};
}

void TakeSessionOptions(const Workspace& workspace, OptionSet* set) {
  if (fs::exists(workspace.session_ini())) set->ParseIniFile(workspace.session_ini());
}

int SessionImageWidth(const Workspace& workspace) {
  StageOptions options;
  OptionSet set;
  BindOptions(set, &options);
  TakeSessionOptions(workspace, &set);
  return options.session.max_image_size_px;
}

PhotoSet LoadPosesOnly(const fs::path& sparse_path, int max_width_px) {
  PhotoSet photos = LoadPhotoSet(ReadReconstruction(sparse_path), "", false);
  DownscalePhotos(max_width_px, &photos);
  return photos;
}

RegionOfInterest RegionOfWorkspace(const Workspace& workspace, const RegionOptions& options) {
  ThrowIfInvalid(options.Check());
  if (!options.box.empty() && options.polygon_path.empty()) return {ParseBox(options.box)};
  if (options.polygon_path.empty() && fs::exists(workspace.state_json())) {
    const Json json = ReadJsonFile(workspace.state_json());
    const JsonNode root(json, workspace.state_json());
    if (const auto region = root.Find("region")) return RegionFromJson(*region);
  }
  const IterationFiles first{workspace.iteration(0)};
  const IterationFiles files = fs::exists(first.sparse()) ? first : LatestIterationFiles(workspace);
  return DefaultRegion(LoadPosesOnly(files.sparse(), SessionImageWidth(workspace)),
                       FrameOrMetric(files.frame_json()), options);
}

WorldFrame FrameOrMetric(const fs::path& frame_json) {
  return fs::exists(frame_json) ? ReadWorldFrame(frame_json) : WorldFrame{true, std::nullopt};
}

WorldFrame FrameOfModel(const fs::path& sparse_path) {
  const fs::path within = sparse_path / "frame.json";
  return FrameOrMetric(fs::exists(within) ? within : sparse_path / ".." / "frame.json");
}

void RecordStageCost(const fs::path& timing_json, const std::string& stage, const StageCost& cost) {
  Json json = fs::exists(timing_json) ? ReadJsonFile(timing_json) : Json::object();
  json[stage] = {{"wall_s", cost.wall_s}, {"cpu_s", cost.cpu_s}, {"peak_mib", cost.peak_mib}};
  WriteJsonFile(json, timing_json);
}

}  // namespace colmap_ext
