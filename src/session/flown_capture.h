// Photos taken by a vehicle through the flight daemon: by default a simulated one, with daemon and
// drone as child processes.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_client.h"
#include "colmap_ext/flight/plan_mission.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/session/session.h"
#include "session/child_program.h"

namespace colmap_ext {

// One path to fly.
struct FlightTask {
  std::vector<Waypoint> waypoints;
  FlightSite site;  // home is filled in from the vehicle
};

class FlownCapture {
 public:
  // Starts what is needed, or uses the daemon that runs for this workspace, and waits until the
  // vehicle is known. Throws Error when that fails.
  // `site_top_m`: highest z of what is known to be there, world; a simulated drone returns above
  // it.
  FlownCapture(const SessionInputs& inputs, const StageOptions& options, const Workspace& workspace,
               double site_top_m, const JobControl& job);
  // A vehicle that this session's own daemon has in the air is sent home first, and waited for.
  ~FlownCapture();
  FlownCapture(const FlownCapture&) = delete;
  FlownCapture& operator=(const FlownCapture&) = delete;

  // Flies to the views whose photos are not in the workspace yet. `while_flying` is called again
  // and again with the number of photos that arrived so far, for work that needs no vehicle. Ends
  // when every view has its photo or was given up by the daemon; the vehicle then hovers. Throws
  // Error when the flight ends without that.
  void Fly(const FlightTask& task, const std::function<void(int photos)>& while_flying,
           const JobControl& job);
  // Sends the vehicle home and waits until it is disarmed.
  void Finish(const JobControl& job);

  // Name of the photo of a view, in the order of the ids.
  static std::string PhotoName(int view_id);

 private:
  void StartDrone(const JobControl& job);
  void StartDaemon(const JobControl& job);
  void RequireChildren() const;
  Json Status() const;
  Json WaitFor(const std::string& what, const std::function<bool(const Json&)>& is_there,
               double timeout_s, const JobControl& job);
  Json WaitForVehicle(const JobControl& job);
  Json WaitForOlderFlight(const JobControl& job);
  void Begin(FlightMission mission, const Json& status);
  void Start(const Json& status, const JobControl& job);
  // False: the flight is over.
  bool Follow(const Json& status, const JobControl& job);
  void WarnWhereItWaits(const Json& status, const JobControl& job);
  void ResumeSimulation(double waited_s, const JobControl& job);
  void TakePoses(const Json& status) const;
  void WarnOfMissingPhotos(const Json& status, const JobControl& job) const;
  void SwapBattery() const;
  void AskPerson(const Json& status) const;

  const SessionInputs& inputs_;
  const StageOptions& options_;
  const Workspace& workspace_;
  const JobControl& job_;
  double site_top_m_;
  bool is_simulated_;
  int link_port_ = 0;
  int drone_port_ = 0;  // HTTP
  std::unique_ptr<ChildProgram> drone_, daemon_;
  std::optional<FlightClient> client_;
  FlightMission mission_;  // of the present task
  std::string last_state_;
  std::chrono::steady_clock::time_point waiting_since_;
  int resumes_ = 0;
  int starts_without_photo_ = 0;
  int photos_at_start_ = 0;
};

}  // namespace colmap_ext
