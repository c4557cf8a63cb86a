#include "colmap_ext/mission/geojson.h"
#include "colmap_ext/mission/qgc_plan.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {

int RunMissionExporter(const Arguments& arguments, const CancelFlag& cancel) {
  CommandLine line(
      "mission_exporter",
      "Writes a path as a mission file. --workspace_path: the path of the newest iteration; "
      "else --input_path path.json and --frame_path frame.json. Formats: qgc_plan "
      "(QGroundControl) and geojson.");
  std::filesystem::path workspace_path, input_path, frame_path, output_path;
  std::string format = "qgc_plan";
  QgcPlanOptions options;
  line.options().Add("", "workspace_path", &workspace_path, "folder of a session");
  line.options().Add("", "input_path", &input_path, "path.json");
  line.options().Add("", "frame_path", &frame_path, "frame.json");
  line.options().Add("", "output_path", &output_path, "file to write");
  line.options().Add("", "format", &format, "qgc_plan or geojson");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments)) return 0;
  RequireOption(output_path, "output_path");
  if (format != "qgc_plan" && format != "geojson") {
    throw UsageError("--format " + format + ": must be qgc_plan or geojson");
  }
  if (!workspace_path.empty()) {
    if (!input_path.empty() || !frame_path.empty()) {
      throw UsageError("give either --workspace_path, or --input_path and --frame_path");
    }
    const Workspace workspace(workspace_path);
    TakeSessionOptions(workspace, &line.options());
    const IterationFiles files = LatestIterationFiles(workspace);
    input_path = files.path_json();
    frame_path = files.frame_json();
  }
  RequireOption(input_path, "input_path");
  RequireOption(frame_path, "frame_path");

  ConsoleSink sink(line.log_level());
  const JobControl job(&sink, &cancel);
  const FlightPath path = ReadPath(input_path);
  const WorldFrame frame = ReadWorldFrame(frame_path);
  WriteFileAtomically(output_path,
                      format == "qgc_plan" ? QgcPlan(path, frame, options) : GeoJson(path, frame));
  job.Info("mission_exporter: " + output_path.string());
  return 0;
}

}  // namespace colmap_ext
