// colmap_ext_flightd: owns one vehicle. One event loop for link, heartbeat, machine and API; disk
// and pictures in workers.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/vehicle_driver.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct DaemonOptions {
  std::filesystem::path workspace_path;
  std::string connection = "udpin://0.0.0.0:14550";  // see ParseMavLinkUrl
  std::filesystem::path signing_key_file;            // empty: nothing is signed
  int api_port = 0;                                  // 0: any free one; flightd.json says which
  // Where the camera's pictures are: a URL, http: or mftp: (MAVLink FTP), in which {index},
  // {index5} (five digits) and {resolution} (low, full) are replaced. Empty: what the camera's
  // reports say.
  std::string picture_url;
  // A folder in which somebody else puts the pictures; matched by time and index. Empty: none.
  std::filesystem::path capture_folder;
  // How much faster than the wall's the vehicle's clock runs; 0: a real vehicle, no clock of its
  // own. With a simulated one, every timeout here runs on the vehicle's clock.
  double simulated_speed = 0;  // [0, 1000]
  FlightOptions flight;
  DriverOptions driver;

  std::string Check() const;
};

// Options of all parts.
void BindOptions(OptionSet& set, DaemonOptions* options);

// Runs until `job` is cancelled. Writes <workspace>/flightd.json when it is ready, and into
// <workspace>/flight/: journal.jsonl, mission.json. Pictures go to images/ and images_full/, what
// is known about them to captures.jsonl beside them. Throws Error when it cannot begin: link, port,
// journal, another daemon in the same workspace.
void RunFlightDaemon(const DaemonOptions& options, const JobControl& job);

}  // namespace colmap_ext
