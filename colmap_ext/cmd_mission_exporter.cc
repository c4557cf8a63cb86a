#include <map>

#include "colmap_ext/mission/export_formats.h"
#include "colmap_ext/mission/qgc_plan.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"
#include "workspace_inputs.h"

namespace colmap_ext {
namespace {

constexpr const char* kFormats = "qgc_plan, wpl, dji_wpml, litchi, kml, geojson or json";

struct MissionExporterPaths {
  std::filesystem::path workspace, input, frame, limits, output;
};

// Formats that a vehicle flies take one battery's flight a file.
bool IsFlown(const std::string& format) {
  return format != "kml" && format != "geojson" && format != "json";
}

void Write(const std::string& format, const FlightPath& path, const WorldFrame& frame,
           const MissionOptions& options, const std::filesystem::path& output) {
  const Mission mission = PrepareMission(path, frame, options);
  if (format == "dji_wpml") {
    WriteDjiKmz(DjiWpml(mission, options), output);
    return;
  }
  using Writer = std::string (*)(const Mission&, const MissionOptions&);
  const std::map<std::string, Writer> writers = {
      {"qgc_plan", [](const Mission& m, const MissionOptions& o) { return QgcPlan(m, o); }},
      {"wpl", Wpl110},
      {"litchi", LitchiCsv},
      {"kml", Kml},
      {"geojson", [](const Mission& m, const MissionOptions&) { return GeoJson(m); }},
      {"json", MissionJson}};
  WriteFileAtomically(output, writers.at(format)(mission, options));
}

void CheckFormat(const std::string& format) {
  for (const char* known : {"qgc_plan", "wpl", "dji_wpml", "litchi", "kml", "geojson", "json"}) {
    if (format == known) return;
  }
  throw UsageError("--format " + format + ": must be " + kFormats);
}

// mission.plan → mission_2.plan
std::filesystem::path NumberedPath(const std::filesystem::path& path, std::size_t number) {
  std::filesystem::path numbered = path;
  numbered.replace_filename(path.stem().string() + "_" + std::to_string(number) +
                            path.extension().string());
  return numbered;
}

void TakeFromWorkspace(CommandLine* line, MissionExporterPaths* paths) {
  if (!paths->input.empty() || !paths->frame.empty()) {
    throw UsageError("give either --workspace_path, or --input_path and --frame_path");
  }
  const Workspace workspace(paths->workspace);
  TakeSessionOptions(workspace, &line->options());
  const IterationFiles files = LatestIterationFiles(workspace);
  paths->input = files.path_json();
  paths->frame = files.frame_json();
}

}  // namespace

int RunMissionExporter(const Arguments& arguments, Program& program) {
  CommandLine line(
      "mission_exporter",
      "Writes a path as a mission file. --workspace_path: the path of the newest iteration; else "
      "--input_path path.json and --frame_path frame.json. A path of several batteries' flights "
      "becomes several files, name_1 …, in the formats that a vehicle flies.");
  MissionExporterPaths paths;
  std::string format = "qgc_plan";
  int flight = 0;
  MissionOptions options;
  line.options().Add("", "workspace_path", &paths.workspace, "folder of a session");
  line.options().Add("", "input_path", &paths.input, "path.json");
  line.options().Add("", "frame_path", &paths.frame, "frame.json");
  line.options().Add("", "limits_path", &paths.limits,
                     "GeoJSON of geofence and no-fly zones, for formats that have a fence");
  line.options().Add("", "output_path", &paths.output, "file to write");
  line.options().Add("", "format", &format, kFormats);
  line.options().Add("", "flight", &flight, "number of the flight to write; 0: all");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  RequireOption(paths.output, "output_path");
  CheckFormat(format);
  if (flight < 0) throw UsageError("--flight must not be negative");
  if (!paths.workspace.empty()) TakeFromWorkspace(&line, &paths);
  RequireOption(paths.input, "input_path");
  RequireOption(paths.frame, "frame_path");

  const JobControl job = program.Job();
  const FlightPath path = ReadPath(paths.input);
  const WorldFrame frame = ReadWorldFrame(paths.frame);
  if (!paths.limits.empty()) SetFence(ReadFlightLimits(paths.limits, frame), frame, &options);
  std::vector<std::string> written;
  const auto write = [&](const FlightPath& part, const std::filesystem::path& output) {
    Write(format, part, frame, options, output);
    job.Info("mission_exporter: " + output.string());
    written.push_back(output.string());
  };
  if (flight > 0) {
    write(PathOfFlight(path, static_cast<std::size_t>(flight) - 1), paths.output);
  } else if (IsFlown(format) && path.flights.size() > 1) {
    for (std::size_t i = 0; i < path.flights.size(); ++i) {
      write(PathOfFlight(path, i), NumberedPath(paths.output, i + 1));
    }
  } else {
    write(path, paths.output);
  }
  if (format == "litchi") {
    job.Info("mission_exporter: in Litchi set the heading mode to custom and the path to straight");
  }
  program.log.Result({{"format", format}, {"files", written}});
  return 0;
}

}  // namespace colmap_ext
