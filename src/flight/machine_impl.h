// The inside of MissionMachine, shared by its source files.
#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/flight/mission_machine.h"

namespace colmap_ext {

// The last command of a kind and what became of it.
struct AwaitedCommand {
  int id = 0;
  double sent_s = 0;
  std::optional<CommandOutcome> outcome;
  std::string text;

  bool IsAccepted() const { return outcome == CommandOutcome::kAccepted; }
  bool HasFailed() const { return outcome && *outcome != CommandOutcome::kAccepted; }
};

class MachineImpl {
 public:
  MachineImpl(const FlightOptions& options, FlightLedger ledger, bool is_shadow);

  // machine_requests.cc
  FlightReply Request(const FlightRequest& request);
  // machine_capture.cc
  void OnCapture(const CaptureReport& report);
  void OnPictureCount(int count);
  void OnStored(int view_id, bool full_resolution, const std::string& file,
                const std::string& sha256);
  void OnFetchFailed(int view_id, bool full_resolution, const std::string& reason);
  // mission_machine.cc
  void OnCommand(int id, CommandOutcome outcome, const std::string& text);
  void OnPreflightFacts(const PreflightFacts& facts);
  void Advance(const VehicleState& vehicle);

  FlightOptions options;
  FlightLedger ledger;
  bool is_shadow = false;
  double now_s = 0;
  MachineOutput output;
  FlightState state = FlightState::kDisconnected;
  std::string reason;
  FlightMission mission;
  int next_stop = 0;
  std::vector<PreflightItem> items;

 private:
  // What has to happen when a pause ends.
  enum class PauseCause { kRequested, kFoundFlying, kPosition, kRefused };

  // machine_requests.cc
  FlightReply Load(const FlightRequest& request);
  FlightReply Append(const FlightRequest& request);
  FlightReply Preflight();
  FlightReply Start();
  FlightReply Pause();
  FlightReply Resume();
  FlightReply Abort(bool land);
  void TakeSurface(const FlightRequest& request);
  void FetchWhatIsCaptured();

  // mission_machine.cc
  void Enter(FlightState next, const std::string& why);
  int Send(FlightCommand command);
  int Send(CommandKind kind);
  AwaitedCommand& Last(CommandKind kind) { return last_[kind]; }
  // Notes it for the journal and in the ledger, which is always what the journal will replay.
  void Record(Json record);
  bool IsFlying() const;
  bool MayCommand() const;
  double InState() const { return now_s - entered_s_; }
  Eigen::Vector3d Position() const;
  FlightSpace Space() const;
  void Expect(std::initializer_list<VehicleMode> modes);
  void AdvanceOnGround();
  void AdvanceInFlight();

  // machine_guards.cc: each returns whether it changed the state.
  bool GuardLink();
  bool GuardArming();
  bool GuardMode();
  bool GuardPosition();
  bool GuardBattery();
  void ReturnFromLinkLoss();
  bool IsPositionGood() const;
  double PercentPerMinute() const;
  bool HasEnergyFor(const std::vector<Eigen::Vector3d>& legs, double hover_s) const;
  void StopHere(PauseCause cause, const std::string& why);

  // machine_stops.cc
  void AdvancePreflight();
  void AdvanceArming();
  void BeginTakeoff();
  void AdvanceTakeoff();
  void BeginStop();
  bool TryStop();
  bool IsDone(int stop) const;
  int NextPendingStop(int from) const;
  void FlyLeg();
  void AdvanceGoto();
  void AdvanceSettle();
  bool IsSettled() const;
  void AdvanceAim();
  bool IsAimed() const;
  void FinishStop();
  void GiveUpStop(const std::string& why);
  void AdvanceFetch();
  void AdvanceHold();
  void AdvancePaused();
  void AdvanceGoingHome();
  void BeginReturn(const std::string& why);
  void BeginLanding(const std::string& why);

  // machine_capture.cc
  void BeginCapture();
  void AskForPicture();
  void AdvanceCapture();
  void AskCamera();
  bool IsWaitingForPicture() const;
  bool TakeUnreported();
  void SettleLatePicture();
  bool IsAtView(int view_id) const;
  void NextAttempt(const std::string& why);
  void TakeReport(int view_id, const CaptureReport& report);
  std::optional<int> AskedView() const;
  bool IsKnown(const CaptureReport& report) const;
  void Fetch(int view_id, bool full_resolution);
  CaptureReport OwnReport(int index) const;
  bool IsFetchingLow() const;

  VehicleState vehicle_;
  double entered_s_ = 0;
  int next_command_ = 1;
  std::map<CommandKind, AwaitedCommand> last_;

  bool has_mission_ = false;
  std::shared_ptr<const RayScene> surface_;
  double surface_top_z_m_ = 0;

  // Modes that the vehicle may be in; leaving_: until a little after an expected one is seen.
  std::set<VehicleMode> expected_, leaving_;
  double arrived_in_mode_s_ = -1;
  FlightState before_link_loss_ = FlightState::kDisconnected;
  double link_lost_s_ = 0;
  PauseCause pause_cause_ = PauseCause::kRequested;
  bool is_resuming_ = false;
  bool start_wanted_ = false;
  bool is_preflight_fresh_ = false;
  bool found_flying_ = true;  // the next sight of a flying vehicle is after a restart
  double good_position_since_s_ = -1;
  double bad_position_since_s_ = -1;

  std::vector<Eigen::Vector3d> legs_;
  std::size_t leg_ = 0;
  int leg_attempts_ = 0;
  Eigen::Vector3d leg_start_ = Eigen::Vector3d::Zero();
  double settled_since_s_ = -1;
  bool settle_repeated_ = false, aim_repeated_ = false;
  bool came_from_stop_ = false;  // at the place of the stop before the next one
  double takeoff_z_m_ = 0;       // world
  int failures_in_a_row_ = 0;
  double flight_started_s_ = 0;
  std::optional<double> percent_at_start_;

  int capture_attempts_ = 0;
  double capture_sent_s_ = 0;
  double retry_at_s_ = -1;      // a refused picture is asked for again
  double camera_asked_s_ = -1;  // why no report came
  bool was_counted_ = false;    // the camera has a picture more
  int counted_index_ = -1;
  double counted_s_ = 0;
  bool knows_count_ = false;                 // the camera told how many pictures it has
  bool is_first_count_ = false;              // … and the next time since the vehicle came
  std::set<std::pair<int, bool>> fetching_;  // view id, full resolution
};

}  // namespace colmap_ext
