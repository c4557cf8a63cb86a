// The inside of SimulatedAutopilot; its methods are spread over the autopilot*.cc files by subject.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/sim/autopilot.h"
#include "sim/drone_fence.h"
#include "sim/drone_missions.h"
#include "sim/drone_parameters.h"

namespace colmap_ext {

enum class FlightMode {
  kStabilize,
  kAltitude,
  kPilot,    // PX4 POSCTL, ArduPilot LOITER: a person's sticks, which are centred here
  kGuided,   // takes targets: PX4 HOLD, ArduPilot GUIDED
  kBrake,    // ArduPilot
  kPosHold,  // ArduPilot
  kTakeoff,  // PX4
  kMission,
  kReturn,
  kSmartReturn,  // ArduPilot
  kLand,
};

struct FlightModeInfo {
  FlightMode mode;
  const char* name;
  std::uint32_t custom_mode;
  bool needs_position;
};
const std::vector<FlightModeInfo>& FlightModesOf(AutopilotPersonality personality);

// COMMAND_LONG or COMMAND_INT, in one form.
struct DroneCommand {
  MavCmd id{};
  std::array<float, 4> param{};            // 1 … 4
  std::optional<double> lat_deg, lon_deg;  // absent: NaN, keep
  float p5 = 0, p6 = 0, p7 = 0;            // of COMMAND_LONG as they are; p7 is z of COMMAND_INT
  MavCoordinateFrame frame = MavCoordinateFrame::kGlobalRelativeAlt;
  bool is_int = false;
  std::uint8_t system = 0, component = 0;  // of the sender
};

struct SimulatedAutopilot::Impl {
  Impl(const AutopilotOptions& options, const GeoPosition& origin, const Eigen::Vector3d& home,
       VehicleMotion::GroundHeight ground);

  // autopilot.cc
  void Tick();
  double Now() const { return static_cast<double>(time_us) * 1e-6; }
  std::uint32_t BootMs() const { return static_cast<std::uint32_t>(time_us / 1000); }
  Eigen::Vector3d Estimated() const { return motion.state().position + gps.EstimateError(); }
  GeoPosition Geo(const Eigen::Vector3d& p) const { return GeoFromEnu(origin, p); }
  double RelativeHeight() const { return Estimated().z() - (home ? home->z() : Estimated().z()); }
  void UpdateHome();
  template <typename Message>
  void Send(const Message& message) {
    frames.push_back(autopilot_sender.Next(message));
  }
  // From component 100 with PX4, from the autopilot with ArduPilot.
  template <typename Message>
  void SendFromCamera(const Message& message) {
    frames.push_back(is_px4 ? camera_sender.Next(message) : autopilot_sender.Next(message));
  }
  void Say(MavSeverity severity, const std::string& text);

  // autopilot_flight.cc
  bool HasPosition() const;   // the estimator would let it fly
  bool IsPrearmGood() const;  // what SYS_STATUS says
  bool CanArm() const;        // what arming finds
  const FlightModeInfo& Info() const;
  bool EnterMode(FlightMode next);  // false: refused
  MavResult Arm(bool wants_armed, bool force);
  MavResult Takeoff(double goal_z);
  void SetGoal(const Eigen::Vector3d& goal);
  bool IsInsideFence(const Eigen::Vector3d& position) const;
  void StepFlight();
  void StepLanded();
  MotionTarget GoalTarget() const;
  MotionTarget ReturnTarget();
  MotionTarget LandTarget() const;
  void Disarm();

  // autopilot_failsafes.cc
  void StepFailsafes();
  void StepLinkFailsafe();
  void StepBatteryFailsafe();
  void StepFenceFailsafe();
  void StepPositionFailsafe();
  void ActOn(const std::string& failsafe, FlightMode mode);

  // autopilot_commands.cc
  void Receive(const MavFrame& frame);
  void ReceiveCommand(const DroneCommand& command, std::uint8_t target_component);
  std::optional<MavResult> Handle(const DroneCommand& command);  // nothing: no answer
  std::optional<MavResult> HandleFlight(const DroneCommand& command);
  MavResult HandleSetMode(const DroneCommand& command);
  MavResult HandleReposition(const DroneCommand& command);
  MavResult HandleConditionYaw(const DroneCommand& command);
  MavResult HandleRequest(std::uint32_t message_id);
  MavResult HandleInterval(const DroneCommand& command);
  void ReceivePositionTarget(const MavSetPositionTargetGlobalInt& target);
  std::optional<double> GoalHeight(const DroneCommand& command) const;  // z of the world
  void Acknowledge(const DroneCommand& command, MavResult result, bool from_camera);

  // autopilot_telemetry.cc
  void StepTelemetry();
  bool SendById(std::uint32_t message_id);  // false: not a message of this vehicle
  void SendHeartbeat();
  void SendSysStatus();
  void SendGpsRaw();
  void SendGlobalPosition();
  void SendAttitude();
  void SendBattery();
  void SendEstimator();
  void SendHome();
  void SendExtendedState();
  void SendTarget();
  void SendVersion();
  void SendFenceStatus();
  void SendMissionCurrent();
  void SendLocalPosition();
  void SendVfrHud();

  // autopilot_camera.cc
  std::optional<MavResult> HandleGimbal(const DroneCommand& command);
  std::optional<MavResult> HandleCamera(const DroneCommand& command);
  MavResult AimGimbal(double pitch_rad, double yaw_rad, std::uint32_t flags);
  void ReceivePitchYaw(const MavGimbalManagerSetPitchyaw& message, const MavFrame& frame);
  MavResult StartCapture(int sequence);
  void StepCamera();
  void TakePicture();
  void ReportPicture(const ShutterEvent& event, bool is_good);
  void SendGimbalStatus();
  void SendGimbalAttitude();
  void SendGimbalInformation();
  void SendMountStatus();
  void SendCameraInformation();
  void SendCameraSettings();
  void SendStorage();
  void SendCaptureStatus();
  std::array<float, 4> CameraQuaternion(bool relative_to_nose) const;

  // autopilot_missions.cc
  bool StartMission(int first);
  void StepMission();
  MotionTarget MissionTarget();
  bool RunDoItem(const MavMissionItemInt& item);  // false: it takes time
  void BeginItem();
  bool IsItemDone();
  void AdvanceMission();

  AutopilotOptions options;
  GeoPosition origin;
  const bool is_px4;
  VehicleMotion motion;
  SimulatedGps gps;
  SimulatedBattery battery;
  SimulatedGimbal gimbal;
  DroneParameters parameters;
  DroneMissions missions;
  DroneFence fence;
  MavSender autopilot_sender, camera_sender;
  std::vector<MavFrame> frames;
  std::vector<ShutterEvent> shutter_events;
  std::vector<std::uint8_t> signing_key;
  std::string picture_url;
  std::int64_t time_us = 0, pending_us = 0;
  std::map<std::uint32_t, std::pair<std::int64_t, std::int64_t>>
      streams;  // id: interval, next (us)

  // Flight; positions in the estimate's ENU frame.
  FlightMode mode;
  bool is_armed = false, is_taking_off = false, is_landed = true, has_crashed = false;
  std::optional<Eigen::Vector3d> home;
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
  double goal_yaw = 0, speed_m_s = 0;
  bool yaw_follows_travel = false;
  enum class ReturnPhase { kClimb, kTravel, kWait, kLand } return_phase = ReturnPhase::kClimb;
  double return_z = 0, return_wait_until_s = 0;
  double armed_at_s = 0, touched_at_s = -1, landed_at_s = -1;

  // Failsafes.
  double gcs_heard_s = -1, position_lost_at_s = -1;
  bool has_lost_link = false, has_breached = false, has_lost_position = false;
  int battery_level = 0;  // 0 fine, 1 low, 2 critical, 3 emergency
  int breaches = 0;
  std::uint32_t breach_ms = 0;
  std::string failsafe;
  bool is_fence_on = false;  // ArduPilot
  std::int64_t next_failsafe_us = 0;

  // Gimbal and camera.
  std::array<std::uint8_t, 2> gimbal_owner{};  // system, component
  CameraFault camera_fault = CameraFault::kNone;
  int captures = 0, last_sequence = 0;
  double last_capture_s = -1e9, shutter_at_s = -1;
  std::deque<std::pair<double, ShutterEvent>> reports;  // when, what
  std::vector<MavCameraImageCaptured> sent_reports;     // by index

  // Mission.
  int mission_item = -1;
  bool is_item_begun = false, is_mission_done = false;
  double item_wait_until_s = -1;

  // For people who watch.
  int pilot_takeovers = 0, motion_commands = 0, arm_commands = 0, capture_commands = 0;
  double last_motion_command_s = -1;
};

}  // namespace colmap_ext
