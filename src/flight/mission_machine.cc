#include "colmap_ext/flight/mission_machine.h"

#include <array>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "flight/machine_impl.h"

namespace colmap_ext {
namespace {

constexpr double kFirstHeartbeatS = 1.2;  // they come once a second

}  // namespace

const char* Name(AutopilotStack stack) {
  constexpr std::array kNames = {"unknown", "PX4", "ArduPilot"};
  return kNames[static_cast<std::size_t>(stack)];
}

const char* Name(VehicleMode mode) {
  constexpr std::array kNames = {"unknown", "pilot",   "guided", "brake",
                                 "takeoff", "mission", "return", "land"};
  return kNames[static_cast<std::size_t>(mode)];
}

const char* Name(FlightState state) {
  constexpr std::array kNames = {
      "DISCONNECTED", "CONNECTED", "IDENTIFIED", "PREFLIGHT", "ARMED",          "TAKEOFF",
      "GOTO",         "SETTLE",    "AIM",        "CAPTURE",   "FETCH",          "HOLD",
      "RETURN",       "LAND",      "DISARMED",   "PAUSED",    "PILOT_OVERRIDE", "LINK_LOST"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* Name(CommandKind kind) {
  constexpr std::array kNames = {"preflight", "guided",  "arm",        "takeoff", "goto",   "turn",
                                 "aim",       "capture", "ask_camera", "hold",    "return", "land"};
  return kNames[static_cast<std::size_t>(kind)];
}

bool IsMotion(CommandKind kind) {
  return kind != CommandKind::kPreflight && kind != CommandKind::kCapture &&
         kind != CommandKind::kAskCamera;
}

MachineImpl::MachineImpl(const FlightOptions& given, FlightLedger replayed, bool shadow)
    : options(given), ledger(std::move(replayed)), is_shadow(shadow) {
  ThrowIfInvalid(options.Check());
  FetchWhatIsCaptured();
}

bool MachineImpl::IsFlying() const {
  switch (state) {
    case FlightState::kDisconnected:
    case FlightState::kConnected:
    case FlightState::kIdentified:
    case FlightState::kPreflight:
    case FlightState::kDisarmed:
      return false;
    default:
      return true;
  }
}

// Commands are only given where the daemon has the vehicle.
bool MachineImpl::MayCommand() const {
  return !is_shadow && state != FlightState::kDisconnected && state != FlightState::kConnected &&
         state != FlightState::kLinkLost && (state != FlightState::kPilotOverride || is_resuming_);
}

Eigen::Vector3d MachineImpl::Position() const { return mission.WorldFromAmsl(*vehicle_.position); }

FlightSpace MachineImpl::Space() const {
  FlightSpace space;
  space.limits = mission.limits;
  if (vehicle_.home) space.home = mission.WorldFromAmsl(*vehicle_.home);
  space.safe_distance_m = mission.safe_distance_m;
  space.slack_m = 1.2 * options.settle_distance_m;
  space.surface = surface_.get();
  return space;
}

void MachineImpl::Enter(FlightState next, const std::string& why) {
  const bool is_same = next == state && why == reason;
  const bool loses_control = next == FlightState::kPilotOverride ||
                             next == FlightState::kLinkLost || next == FlightState::kDisarmed ||
                             next == FlightState::kDisconnected;
  if (loses_control) {
    output.cancel_motion = true;
    output.commands.clear();
    is_resuming_ = false;
    start_wanted_ = false;
  }
  if (!is_same) {
    Record({{"type", "state"}, {"from", Name(state)}, {"to", Name(next)}, {"reason", why}});
  }
  if (next != state) entered_s_ = now_s;
  state = next;
  reason = why;
}

int MachineImpl::Send(FlightCommand command) {
  command.id = next_command_++;
  const bool is_question =
      command.kind == CommandKind::kAskCamera && !is_shadow && state != FlightState::kLinkLost;
  if (!MayCommand() && !is_question) return command.id;
  command.stop = next_stop;
  AwaitedCommand& awaited = last_[command.kind];
  awaited = {};
  awaited.id = command.id;
  awaited.sent_s = now_s;
  Record({{"type", "intent"}, {"command", Name(command.kind)}, {"stop", command.stop}});
  output.commands.push_back(command);
  return command.id;
}

int MachineImpl::Send(CommandKind kind) {
  FlightCommand command;
  command.kind = kind;
  return Send(command);
}

void MachineImpl::Record(Json record) {
  ApplyRecord(JsonNode(record, "flight journal"), &ledger);
  output.records.push_back(std::move(record));
}

// From now on the vehicle may be in these modes, and until one of them is seen also in those that
// it may be in now.
void MachineImpl::Expect(std::initializer_list<VehicleMode> modes) {
  leaving_ = expected_;
  leaving_.insert(vehicle_.mode);
  expected_ = modes;
  arrived_in_mode_s_ = -1;
}

void MachineImpl::OnCommand(int id, CommandOutcome outcome, const std::string& text) {
  for (auto& [kind, awaited] : last_) {
    if (awaited.id != id) continue;
    awaited.outcome = outcome;
    awaited.text = text;
  }
}

void MachineImpl::OnPreflightFacts(const PreflightFacts& facts) {
  if (!has_mission_ || !vehicle_.home) return;
  const double home_z_m = mission.WorldFromAmsl(*vehicle_.home).z();
  const double top_z_m = surface_ ? surface_top_z_m_ : mission.transit_z_m.value_or(home_z_m);
  items = CheckPreflight(vehicle_, facts, mission, top_z_m - home_z_m, options);
  is_preflight_fresh_ = true;
}

void MachineImpl::Advance(const VehicleState& vehicle) {
  vehicle_ = vehicle;
  if (GuardLink() || GuardArming()) return;
  SettleLatePicture();
  if (!IsFlying()) {
    AdvanceOnGround();
    return;
  }
  if (state == FlightState::kLinkLost) return;
  if (GuardMode() || GuardPosition() || GuardBattery()) return;
  AdvanceInFlight();
}

void MachineImpl::AdvanceOnGround() {
  switch (state) {
    case FlightState::kDisconnected:
      Enter(FlightState::kConnected, "the vehicle was heard");
      return;
    case FlightState::kConnected:
      if (!vehicle_.is_identified) return;
      found_flying_ = false;
      Enter(FlightState::kIdentified, vehicle_.description);
      is_first_count_ = true;
      AskCamera();
      return;
    case FlightState::kPreflight:
      AdvancePreflight();
      return;
    default:
      return;
  }
}

void MachineImpl::AdvanceInFlight() {
  switch (state) {
    case FlightState::kArmed:
      // The take-off changes the mode: not before another heartbeat said that it is still ours.
      if (InState() > kFirstHeartbeatS) BeginTakeoff();
      return;
    case FlightState::kTakeoff:
      AdvanceTakeoff();
      return;
    case FlightState::kGoto:
      AdvanceGoto();
      return;
    case FlightState::kSettle:
      AdvanceSettle();
      return;
    case FlightState::kAim:
      AdvanceAim();
      return;
    case FlightState::kCapture:
      AdvanceCapture();
      return;
    case FlightState::kFetch:
      AdvanceFetch();
      return;
    case FlightState::kHold:
      AdvanceHold();
      return;
    case FlightState::kPaused:
    case FlightState::kPilotOverride:
      AdvancePaused();
      return;
    case FlightState::kReturn:
    case FlightState::kLand:
      AdvanceGoingHome();
      return;
    default:
      return;
  }
}

MissionMachine::MissionMachine(const FlightOptions& options, FlightLedger ledger, bool is_shadow)
    : impl_(std::make_unique<MachineImpl>(options, std::move(ledger), is_shadow)) {}
MissionMachine::~MissionMachine() = default;

FlightReply MissionMachine::Request(const FlightRequest& request, double now_s) {
  impl_->now_s = now_s;
  return impl_->Request(request);
}

void MissionMachine::OnCommand(int id, CommandOutcome outcome, const std::string& text,
                               double now_s) {
  impl_->now_s = now_s;
  impl_->OnCommand(id, outcome, text);
}

void MissionMachine::OnPreflightFacts(const PreflightFacts& facts, double now_s) {
  impl_->now_s = now_s;
  impl_->OnPreflightFacts(facts);
}

void MissionMachine::OnCapture(const CaptureReport& report, double now_s) {
  impl_->now_s = now_s;
  impl_->OnCapture(report);
}

void MissionMachine::OnPictureCount(int count, double now_s) {
  impl_->now_s = now_s;
  impl_->OnPictureCount(count);
}

void MissionMachine::OnStored(int view_id, bool full_resolution, const std::string& file,
                              const std::string& sha256, double now_s) {
  impl_->now_s = now_s;
  impl_->OnStored(view_id, full_resolution, file, sha256);
}

void MissionMachine::OnFetchFailed(int view_id, bool full_resolution, const std::string& reason,
                                   double now_s) {
  impl_->now_s = now_s;
  impl_->OnFetchFailed(view_id, full_resolution, reason);
}

void MissionMachine::Advance(const VehicleState& vehicle, double now_s) {
  impl_->now_s = now_s;
  impl_->Advance(vehicle);
}

MachineOutput MissionMachine::TakeOutput() {
  MachineOutput taken = std::move(impl_->output);
  impl_->output = {};
  return taken;
}

FlightState MissionMachine::state() const { return impl_->state; }
const std::string& MissionMachine::reason() const { return impl_->reason; }
const FlightMission& MissionMachine::mission() const { return impl_->mission; }
const FlightLedger& MissionMachine::ledger() const { return impl_->ledger; }
int MissionMachine::next_stop() const { return impl_->next_stop; }
const std::vector<PreflightItem>& MissionMachine::preflight() const { return impl_->items; }

}  // namespace colmap_ext
