// colmap_ext: active image-based modeling for COLMAP. One verb a command, as in COLMAP.
#include <array>
#include <iostream>
#include <new>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/util/text.h"
#include "commands.h"
#include "manual.h"
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
         << "       colmap_ext <command> -h     all options of a command, with defaults\n"
         << "       colmap_ext help [<command>] [--format text|man|completion]\n\n"
         << "Commands:\n";
  for (const Command& command : kCommands) {
    std::string name = command.name;
    name.resize(24, ' ');
    stream << "  " << name << command.summary << '\n';
  }
  stream << "\nExit codes: " << kExitCodes << ".\n";
}

// OpenCV has an exception of its own for too little memory.
int RunSayingOutOfMemory(const Command& command, const Arguments& arguments, Program& program) {
  try {
    return command.run(arguments, program);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    throw;
  }
}

int RunCommand(const Command& command, const Arguments& arguments) {
  Program program(std::string("colmap_ext ") + command.name, arguments);
  const SignalWatcher watcher(&program.cancel, &program.log);
  return program.Run(arguments, [&] { return RunSayingOutOfMemory(command, arguments, program); });
}

const Command* FindCommand(const std::string& name) {
  for (const Command& command : kCommands) {
    if (name == command.name) return &command;
  }
  return nullptr;
}

std::vector<std::string> CommandNames() {
  std::vector<std::string> names;
  for (const Command& command : kCommands) names.emplace_back(command.name);
  return names;
}

int UnknownCommand(const std::string& name) {
  std::cerr << "colmap_ext: no such command: " << name << Suggestion(name, CommandNames())
            << "; `colmap_ext help` lists them\n";
  return 2;
}

int PrintHelpOfAll(const std::string& format) {
  std::vector<CommandSummary> summaries;
  const std::vector<std::string> names = CommandNames();
  for (const Command& command : kCommands) summaries.push_back({command.name, command.summary});
  if (format == "text") {
    PrintHelp(std::cout);
  } else if (format == "names") {
    for (const std::string& name : names) std::cout << name << '\n';
  } else if (format == "man") {
    std::cout << ManualPageOfColmapExt(summaries);
  } else if (format == "completion") {
    for (const Command& command : kCommands) {
      RunCommand(command, {"--help_format", "completion"});
    }
    std::cout << CompletionFunction("colmap_ext", names);
  } else {
    std::cerr << "colmap_ext: help --format " << format
              << ": must be text, man, completion or names\n";
    return 2;
  }
  return 0;
}

// help [COMMAND] [--format FORMAT]
int Help(const Arguments& arguments) {
  std::string format = "text", name;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--format" && i + 1 < arguments.size()) {
      format = arguments[++i];
    } else if (name.empty() && !arguments[i].starts_with("-")) {
      name = arguments[i];
    } else {
      std::cerr << "colmap_ext: usage: colmap_ext help [COMMAND] [--format FORMAT]\n";
      return 2;
    }
  }
  if (name.empty()) return PrintHelpOfAll(format);
  const Command* command = FindCommand(name);
  if (command == nullptr) return UnknownCommand(name);
  return RunCommand(*command, {"--help_format", format});
}

int Run(const Arguments& arguments) {
  if (arguments.empty()) {
    PrintHelp(std::cerr);
    return 2;
  }
  const std::string& verb = arguments[0];
  const Arguments rest(arguments.begin() + 1, arguments.end());
  if (verb == "help") return Help(rest);
  if (verb == "-h" || verb == "--help") return Help({});
  if (verb == "version" || verb == "--version") {
    std::cout << "colmap_ext " COLMAP_EXT_VERSION "\n";
    return 0;
  }
  const Command* command = FindCommand(verb);
  return command == nullptr ? UnknownCommand(verb) : RunCommand(*command, rest);
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::Run(colmap_ext::Arguments(argv + 1, argv + argc));
}
