// colmap_ext_dronesim: a simulated vehicle with gimbal and camera, for flying without one.
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/sim/drone_simulator.h"
#include "colmap_ext/sim/drone_site.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/options.h"
#include "command_line.h"
#include "program.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr int kCrashExitCode = 70;

struct DronesimOptions {
  std::string scene, personality = "px4", home;
  fs::path scene_path;
  double texel_scale = 1;
  SimulatedCameraOptions camera;
  RenderOptions render;
  DroneSimulatorOptions simulator;
};

void AddOptions(DronesimOptions* o, OptionSet* set) {
  DroneSimulatorOptions* s = &o->simulator;
  set->Add("", "scene", &o->scene, "scene made by procedure: church, boxes or gate");
  set->Add("", "scene_path", &o->scene_path, "or a textured model (OBJ, glTF, COLLADA, …)");
  set->Add("", "texel_scale", &o->texel_scale,
           "above 1: coarser, quicker textures for procedural scenes ([0.5, 16])");
  set->Add("", "personality", &o->personality, "px4 or ardupilot");
  set->Add("", "connection", &s->connection,
           "udpout://host:port, udpin://host:port, tcp://host:port, tcpin://host:port");
  set->Add("", "http_port", &s->http_port,
           "of pictures, status and faults, on 127.0.0.1; 0: any, see the first line printed");
  set->Add("", "output_path", &s->output_path,
           "folder for low/, full/, true_poses.txt, captures.jsonl; without pictures yet");
  set->Add("", "home", &o->home,
           "EAST,NORTH in the scene, metres; empty: a free place beside the model");
  set->Add("", "speed", &s->speed, "simulated seconds a second ([0.1, 100])");
  set->Add("", "seed", &s->autopilot.seed, "of wind, GPS, gimbal and link; not of the scene");
  set->Add("", "system_id", &s->autopilot.system_id, "of the vehicle in MAVLink ([1, 255])");
  set->Add("", "faults", &s->faults, "from the start on: a JSON object as of POST /faults");
  set->Add("", "signing_key_file", &s->signing_key_path, "32 bytes or 64 hexadecimal digits");
  set->Add("", "full_resolution", &s->renders_full, "also pictures in full resolution (0 or 1)");
  BindOptions(*set, &s->autopilot);
  BindOptions(*set, &o->camera);
  BindOptions(*set, &o->render);
}

void CheckOptions(DronesimOptions* o) {
  if (o->scene.empty() == o->scene_path.empty()) {
    throw UsageError("give either --scene or --scene_path");
  }
  if (o->simulator.output_path.empty()) throw UsageError("--output_path is required");
  o->simulator.autopilot.personality = ParsePersonality(o->personality);
  ThrowIfInvalid(o->simulator.Check());
  ThrowIfInvalid(o->camera.Check());
  ThrowIfInvalid(o->render.Check());
}

// The scene of a session with the same options.
TexturedScene OpenScene(const DronesimOptions& o, const JobControl& job) {
  if (!o.scene.empty()) return MakeScene(o.scene, o.camera.seed, o.texel_scale);
  return LoadScene(o.scene_path, LoadSceneOptions(), job);
}

Eigen::Vector3d HomeOf(const DronesimOptions& o, const DroneSite& site) {
  if (o.home.empty()) return site.DefaultHome();
  double east = 0, north = 0;
  int used = 0;
  if (std::sscanf(o.home.c_str(), "%lf,%lf%n", &east, &north, &used) != 2 ||
      static_cast<std::size_t>(used) != o.home.size()) {
    throw UsageError("--home must be EAST,NORTH in metres, not '" + o.home + "'");
  }
  return site.OnSurface(east, north);
}

int Fly(const DronesimOptions& o, const JobControl& job) {
  const TexturedScene scene = OpenScene(o, job);
  const DroneSite site(scene);
  const Renderer renderer(scene, o.render);
  const SimulatedCamera camera(renderer, scene.origin, o.camera);
  boost::asio::io_context io;
  boost::asio::signal_set signals(io, SIGINT, SIGTERM);
  DroneSimulator simulator(
      &io, o.simulator, scene.origin, HomeOf(o, site), site, camera, [] { _exit(kCrashExitCode); },
      job);
  signals.async_wait([&](const boost::system::error_code& error, int) {
    if (!error) io.stop();
  });
  std::cout << simulator.ReadyLine().dump() << std::endl;
  simulator.Start();
  io.run();
  simulator.Stop();
  return 0;
}

int Run(const std::vector<std::string>& arguments, Program& program) {
  DronesimOptions options;
  CommandLine line("colmap_ext_dronesim",
                   "A simulated drone: MAVLink, gimbal, camera, faults (docs/simulated_drone.md). "
                   "It runs until it is stopped.");
  AddOptions(&options, &line.options());
  if (!line.Parse(arguments, &program.log)) return 0;
  CheckOptions(&options);
  return Fly(options, program.Job());
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  colmap_ext::Program program("colmap_ext_dronesim", arguments);
  return program.Run(arguments, [&] { return colmap_ext::Run(arguments, program); });
}
