// A simulated drone on its links: MAVLink, HTTP and time, on one event loop.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/sim/autopilot.h"
#include "colmap_ext/sim/drone_site.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/util/job_control.h"

namespace boost::asio {
class io_context;
}

namespace colmap_ext {

struct DroneSimulatorOptions {
  std::string connection = "udpout://127.0.0.1:14550";  // as MavLinkUrl
  int http_port = 0;                                    // on 127.0.0.1, [0, 65535]; 0: any
  double speed = 1;                                     // simulated seconds a second, [0.1, 100]
  std::string faults = "{}";                            // JSON object, as POST /faults
  std::filesystem::path signing_key_path;               // empty: unsigned
  std::filesystem::path output_path;                    // for pictures and truth
  bool renders_full = true;                             // full pictures too
  AutopilotOptions autopilot;

  std::string Check() const;
};

class DroneSimulator {
 public:
  // Opens its links at once; time starts with Start(). `io`, `site` and `camera` must outlive it.
  // `crash` is called for the fault of that name, and is not expected to return. Throws Error or
  // UsageError naming what cannot be opened.
  DroneSimulator(boost::asio::io_context* io, const DroneSimulatorOptions& options,
                 const GeoPosition& origin, const Eigen::Vector3d& home, const DroneSite& site,
                 const SimulatedCamera& camera, std::function<void()> crash, const JobControl& job);
  ~DroneSimulator();  // after the picture at hand
  DroneSimulator(const DroneSimulator&) = delete;
  DroneSimulator& operator=(const DroneSimulator&) = delete;

  void Start();
  void Stop();  // no event is left on the loop after it

  // The line that a program prints when it is ready (docs/simulated_drone.md).
  Json ReadyLine() const;
  Json Status() const;
  int http_port() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace colmap_ext
