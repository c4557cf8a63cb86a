// colmap_ext: active image-based modeling for COLMAP. One verb a command, as in COLMAP.
#include <array>
#include <iostream>
#include <string>
#include <vector>

#include "commands.h"
#include "signal_watcher.h"

namespace colmap_ext {
namespace {

struct Command {
  const char* name;
  const char* summary;  // one line for `colmap_ext help`
  int (*run)(const Arguments& arguments, Program& program);
};

constexpr std::array kCommands = {
    Command{"active_capture", "the whole loop: photos, model, coverage, next views, flight",
            RunActiveCapture},
    Command{"sparse_updater", "photos to a sparse model; later only the new photos",
            RunSparseUpdater},
    Command{"superpixel_segmenter", "photo to polygons and triangles along its line segments",
            RunSuperpixelSegmenter},
    Command{"superpixel_stereo", "photos and sparse model to meshes, depth maps and fused points",
            RunSuperpixelStereo},
    Command{"surface_reconstructor", "fused points to a surface with its signal",
            RunSurfaceReconstructor},
    Command{"coverage_evaluator", "surface and photos to covered and uncovered iso-points",
            RunCoverageEvaluator},
    Command{"view_planner", "coverage map to the next views", RunViewPlanner},
    Command{"path_planner", "next views to a flight that is proved to be safe", RunPathPlanner},
    Command{"flight_planner", "a classic flight pattern around a box, polygon or model",
            RunFlightPlanner},
    Command{"mission_exporter", "flight to a file that a drone's programs read",
            RunMissionExporter},
    Command{"flight_client", "talks to the flight daemon: status, start, pause, abort …",
            RunFlightClient},
    Command{"scene_renderer", "pictures and exact depth of a textured scene", RunSceneRenderer},
    Command{"dense_reconstructor", "full-size photos with poses to a dense cloud and mesh",
            RunDenseReconstructor},
    Command{"model_evaluator", "error and completeness of a model against the truth",
            RunModelEvaluator},
    Command{"report_generator", "the page of a session", RunReportGenerator},
};

void PrintHelp(std::ostream& stream) {
  stream << "colmap_ext " COLMAP_EXT_VERSION ": active image-based modeling for COLMAP\n\n"
         << "Usage: colmap_ext <command> [--option value] [--Section.option value]\n"
         << "       colmap_ext <command> -h     all options of a command, with defaults\n\n"
         << "Commands:\n";
  for (const Command& command : kCommands) {
    std::string name = command.name;
    name.resize(24, ' ');
    stream << "  " << name << command.summary << '\n';
  }
  stream << "\nExit codes: 0 done, 1 failed, 2 wrong usage.\n";
}

int RunCommand(const Command& command, const Arguments& arguments) {
  Program program(std::string("colmap_ext ") + command.name, arguments);
  const SignalWatcher watcher(&program.cancel, &program.log);
  return program.Run(arguments, [&] { return command.run(arguments, program); });
}

int Run(const Arguments& arguments) {
  if (arguments.empty()) {
    PrintHelp(std::cerr);
    return 2;
  }
  const std::string& verb = arguments[0];
  if (verb == "help" || verb == "-h" || verb == "--help") {
    PrintHelp(std::cout);
    return 0;
  }
  if (verb == "version" || verb == "--version") {
    std::cout << "colmap_ext " COLMAP_EXT_VERSION "\n";
    return 0;
  }
  for (const Command& command : kCommands) {
    if (verb == command.name) {
      return RunCommand(command, Arguments(arguments.begin() + 1, arguments.end()));
    }
  }
  std::cerr << "colmap_ext: no such command: " << verb << "; `colmap_ext help` lists them\n";
  return 2;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::Run(colmap_ext::Arguments(argv + 1, argv + argc));
}
