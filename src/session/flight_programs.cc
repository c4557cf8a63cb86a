#include "session/flight_programs.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"
#include "session/child_program.h"

namespace colmap_ext {
namespace {

constexpr double kReturnAboveSiteM = 15;

// The parameter of the autopilot that says how high it returns, metres above home.
std::string ReturnHeight(const std::string& personality, double height_m) {
  return personality == "px4" ? "RTL_RETURN_ALT=" + FormatNumber("%g", height_m)
                              : "RTL_ALT=" + FormatNumber("%g", 100 * height_m);  // centimetres
}

std::vector<std::string> DaemonArguments(const StageOptions& options, const Workspace& workspace) {
  const std::filesystem::path ini = workspace.logs() / "flight.ini";
  OptionSet set;
  FlightOptions flight = options.flight;
  BindOptions(set, &flight);
  WriteFileAtomically(ini, set.ToIni());
  return {FindSibling("colmap_ext_flightd"), "--project_path", ini, "--workspace_path",
          workspace.root()};
}

}  // namespace

int FreeUdpPort() {
  try {
    boost::asio::io_context io;
    const boost::asio::ip::udp::socket socket(io, {boost::asio::ip::address_v4::loopback(), 0});
    return socket.local_endpoint().port();
  } catch (const boost::system::system_error& error) {
    throw Error("no free port on 127.0.0.1: " + error.code().message());
  }
}

std::vector<std::string> DroneArguments(const SessionInputs& inputs, const StageOptions& options,
                                        const Workspace& workspace, double site_top_m,
                                        int link_port, const std::filesystem::path& output_path) {
  const std::filesystem::path ini = workspace.logs() / "drone.ini";
  OptionSet set;
  SimulatedCameraOptions camera = options.simulation;
  RenderOptions render = options.render;
  BindOptions(set, &camera);
  BindOptions(set, &render);
  WriteFileAtomically(ini, set.ToIni());
  const std::string& personality = options.session.personality;
  // The receiver's errors: most of them wander slowly, as over a flight they do.
  const double gps_m = options.simulation.gps_noise_m;
  std::vector<std::string> arguments = {
      FindSibling("colmap_ext_dronesim"),
      "--project_path",
      ini,
      "--output_path",
      output_path,
      "--personality",
      personality,
      "--connection",
      "udpout://127.0.0.1:" + std::to_string(link_port),
      "--speed",
      FormatNumber("%g", options.session.simulation_speed),
      "--full_resolution",
      options.session.full_resolution ? "1" : "0",
      "--Drone.failsafes",
      "safe",
      "--Drone.parameters",
      ReturnHeight(personality, std::ceil(site_top_m + kReturnAboveSiteM)),
      "--Drone.gps_bias_m",
      FormatNumber("%g", gps_m),
      "--Drone.gps_noise_m",
      FormatNumber("%g", gps_m / 3)};
  if (inputs.scene.empty()) {
    arguments.insert(arguments.end(), {"--scene_path", inputs.scene_path});
  } else {
    arguments.insert(arguments.end(), {"--scene", inputs.scene});
  }
  return arguments;
}

std::vector<std::string> SimulationDaemonArguments(const StageOptions& options,
                                                   const Workspace& workspace, int link_port,
                                                   int drone_port) {
  std::vector<std::string> arguments = DaemonArguments(options, workspace);
  arguments.insert(
      arguments.end(),
      {"--connection", "udpin://127.0.0.1:" + std::to_string(link_port), "--simulated_speed",
       FormatNumber("%g", options.session.simulation_speed), "--picture_url",
       "http://127.0.0.1:" + std::to_string(drone_port) +
           "/pictures/{resolution}/img_{index5}.jpg"});
  return arguments;
}

std::vector<std::string> VehicleDaemonArguments(const SessionInputs& inputs,
                                                const StageOptions& options,
                                                const Workspace& workspace) {
  std::vector<std::string> arguments = DaemonArguments(options, workspace);
  arguments.insert(arguments.end(), {"--connection", options.session.vehicle});
  if (!inputs.picture_url.empty()) {
    arguments.insert(arguments.end(), {"--picture_url", inputs.picture_url});
  }
  if (!inputs.capture_folder.empty()) {
    arguments.insert(arguments.end(), {"--capture_folder", inputs.capture_folder});
  }
  return arguments;
}

}  // namespace colmap_ext
