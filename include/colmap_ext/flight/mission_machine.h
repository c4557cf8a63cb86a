// The state machine of a flight. Pure: telemetry, requests and the time go in, commands and journal
// records come out. It knows neither MAVLink nor files nor clocks.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_ledger.h"
#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/preflight.h"
#include "colmap_ext/flight/segment_checks.h"
#include "colmap_ext/flight/vehicle_state.h"

namespace colmap_ext {

enum class FlightState {
  kDisconnected,
  kConnected,   // heard, but not yet known well enough
  kIdentified,  // on the ground, nothing asked for
  kPreflight,   // checks are running, or done and good
  kArmed,
  kTakeoff,
  kGoto,
  kSettle,
  kAim,
  kCapture,
  kFetch,  // all views flown, waiting for pictures
  kHold,   // all views flown and fetched, hovering for more
  kReturn,
  kLand,
  kDisarmed,  // after a flight
  kPaused,
  kPilotOverride,
  kLinkLost,
};
const char* Name(FlightState state);

enum class CommandKind {
  kPreflight,  // parameters, fence: moves nothing
  kGuided,     // take the mode in which the vehicle obeys
  kArm,
  kTakeoff,
  kGoTo,
  kTurn,
  kAim,
  kCapture,
  kAskCamera,  // what happened to the picture: moves nothing
  kHold,
  kReturn,
  kLand,
};
const char* Name(CommandKind kind);
// Whether the command moves the vehicle, changes its mode, or turns its gimbal.
bool IsMotion(CommandKind kind);

struct FlightCommand {
  int id = 0;  // grows; answers name it
  CommandKind kind = CommandKind::kPreflight;
  GeoPosition target;  // above mean sea level: kGoTo, kTakeoff
  double relative_height_m = 0;
  double yaw_rad = 0;    // kGoTo, kTurn
  double pitch_rad = 0;  // kAim
  double speed_m_s = 0;  // kGoTo
  int sequence = 0;      // kCapture
  int after_index = -1;  // kAskCamera: the last picture known
  int stop = -1;
};

enum class CommandOutcome { kAccepted, kRejected, kNoAnswer };

struct FlightRequest {
  enum class Kind { kLoad, kAppend, kPreflight, kStart, kPause, kResume, kAbort };
  Kind kind = Kind::kPreflight;
  // kLoad: the mission, with its surface (null where the mission has none).
  FlightMission mission;
  std::shared_ptr<const RayScene> surface;
  double surface_top_z_m = 0;     // highest point of the surface, world
  std::vector<FlightStop> stops;  // kAppend, after the present ones; mission.revision: the new one.
                                  // A surface replaces the present one
  bool land = false;              // kAbort: here, instead of returning
};

struct FlightReply {
  bool is_accepted = true;
  std::string reason;  // why not, and what to do
};

// A picture to fetch from the camera.
struct FetchRequest {
  int view_id = -1;
  std::string photo;
  CaptureReport capture;
  bool full_resolution = false;
};

struct MachineOutput {
  std::vector<Json> records;            // on disk before the commands are sent
  std::vector<FlightCommand> commands;  // in order
  std::vector<FetchRequest> fetches;
  bool cancel_motion = false;  // commands given earlier must not be repeated any more
};

class MachineImpl;

class MissionMachine {
 public:
  // `ledger`: what earlier runs did. When it was flying, the first sight of an armed vehicle ends
  // in kPaused: nothing moves before `resume` or `abort`. Throws UsageError for bad options.
  MissionMachine(const FlightOptions& options, FlightLedger ledger, bool is_shadow = false);
  ~MissionMachine();
  MissionMachine(const MissionMachine&) = delete;
  MissionMachine& operator=(const MissionMachine&) = delete;

  FlightReply Request(const FlightRequest& request, double now_s);
  void OnCommand(int id, CommandOutcome outcome, const std::string& text, double now_s);
  void OnPreflightFacts(const PreflightFacts& facts, double now_s);
  void OnCapture(const CaptureReport& report, double now_s);
  // How many pictures the camera says that it has taken; index of the last one is one less.
  void OnPictureCount(int count, double now_s);
  void OnStored(int view_id, bool full_resolution, const std::string& file,
                const std::string& sha256, double now_s);
  void OnFetchFailed(int view_id, bool full_resolution, const std::string& reason, double now_s);
  // To be called at least ten times a second, and after every change of `vehicle`.
  void Advance(const VehicleState& vehicle, double now_s);

  // What came out since the last call.
  MachineOutput TakeOutput();

  FlightState state() const;
  const std::string& reason() const;  // of the present state
  const FlightMission& mission() const;
  const FlightLedger& ledger() const;
  int next_stop() const;  // index into mission().stops; their number when all are done
  const std::vector<PreflightItem>& preflight() const;

 private:
  std::unique_ptr<MachineImpl> impl_;
};

}  // namespace colmap_ext
