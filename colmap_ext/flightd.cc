// colmap_ext_flightd: the flight-control daemon of one vehicle.
#include <iostream>

#include "colmap_ext/flight/flight_daemon.h"
#include "colmap_ext/util/error.h"
#include "command_line.h"
#include "signal_watcher.h"

namespace colmap_ext {
namespace {

int RunDaemon(const std::vector<std::string>& arguments) {
  CommandLine line("flightd",
                   "Owns one vehicle over MAVLink 2 and flies the missions that the planner loads "
                   "through an API on 127.0.0.1 (docs/flight_api.md). Read docs/flying.md before "
                   "it meets a real one.");
  DaemonOptions options;
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments)) return 0;
  std::atomic<bool> cancel = false;
  const SignalWatcher watcher(&cancel);
  ConsoleSink sink(line.log_level());
  RunFlightDaemon(options, JobControl(&sink, &cancel));
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  try {
    return colmap_ext::RunDaemon({argv + 1, argv + argc});
  } catch (const colmap_ext::UsageError& error) {
    std::cerr << "colmap_ext_flightd: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "colmap_ext_flightd: " << error.what() << '\n';
    return 1;
  }
}
