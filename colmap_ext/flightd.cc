// colmap_ext_flightd: the flight-control daemon of one vehicle.
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_daemon.h"
#include "command_line.h"
#include "program.h"
#include "signal_watcher.h"

namespace colmap_ext {
namespace {

int RunDaemon(const std::vector<std::string>& arguments, Program& program) {
  CommandLine line("colmap_ext_flightd",
                   "Owns one vehicle over MAVLink 2 and flies the missions that the planner loads "
                   "through an API on 127.0.0.1 (docs/flight_api.md). Read docs/flying.md before "
                   "it meets a real one.");
  DaemonOptions options;
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  const SignalWatcher watcher(&program.cancel, &program.log);
  RunFlightDaemon(options, program.Job());
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  colmap_ext::Program program("colmap_ext_flightd", arguments);
  return program.Run(arguments, [&] { return colmap_ext::RunDaemon(arguments, program); });
}
