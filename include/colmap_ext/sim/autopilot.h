// A simulated autopilot, its gimbal and its camera's shutter, as MAVLink sees them: packets in,
// packets out, time by Step(). No socket, no clock, no picture.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/sim/vehicle_motion.h"
#include "colmap_ext/sim/vehicle_parts.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

enum class AutopilotPersonality { kPx4, kArduPilot };

// "px4" or "ardupilot". Throws UsageError otherwise.
AutopilotPersonality ParsePersonality(const std::string& name);

struct AutopilotOptions {
  AutopilotPersonality personality = AutopilotPersonality::kPx4;
  // "stock": the failsafes of a new vehicle, most of them off. "safe": those that our daemon wants.
  std::string failsafes = "stock";
  // Further parameters, "NAME=VALUE,NAME=VALUE".
  std::string parameters;
  // "v2": MAVLink's gimbal protocol; "mount": only the older MOUNT_CONTROL; "none".
  std::string gimbal_protocol = "v2";
  // "v2": MAVLink's camera protocol; "trigger": only DIGICAM_CONTROL.
  std::string camera_protocol = "v2";
  // What 263 says of the file: "none" (as PX4), "http" or "mftp".
  std::string file_url = "none";
  double undulation_m = 47.4;      // of the geoid: ellipsoidal height minus AMSL, [-120, 120]
  double home_yaw_deg = 0;         // where the nose points at the start, [-360, 360]
  double prearm_ready_s = 5;       // from power on until the vehicle says it could arm, [0, 600]
  double estimator_ready_s = 8;    // until it really can; ArduPilot: 16 more, [0, 600]
  double capture_spacing_s = 2.5;  // ArduPilot: least time between pictures, [0, 60]
  int system_id = 1;               // [1, 255]
  std::uint64_t seed = 1;          // of wind, GPS and gimbal
  VehicleMotionOptions motion;
  GpsOptions gps;
  BatteryOptions battery;
  GimbalOptions gimbal;

  std::string Check() const;
};
// Section "Drone", without personality, system_id and seed; with those of the parts.
void BindOptions(OptionSet& set, AutopilotOptions* options);

// A picture that the shutter took.
struct ShutterEvent {
  int index = 0;  // from 0 on, as the reports say
  std::uint32_t time_boot_ms = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // true, world (ENU), metres
  ViewDirection direction;                             // true
  GeoPosition gps;  // what the receiver said, AMSL; goes into EXIF
  double sigma_horizontal_m = 0, sigma_vertical_m = 0;
};

enum class CameraFault {
  kNone,
  kRefuses,  // captures are answered by FAILED
  kReports,  // accepted, then reported as failed (263 with result 0)
  kSilent,   // accepted, and nothing comes
};

// What a person with an overview sees; never sent.
struct DroneTruth {
  double time_s = 0;  // since power on
  MotionState motion;
  double gimbal_pitch_rad = 0, gimbal_heading_rad = 0;
  bool is_gimbal_stuck = false;
  bool is_armed = false, is_landed = true, has_crashed = false;
  std::string mode;      // the autopilot's own name
  std::string failsafe;  // the last one that acted; empty: none
  double battery_percent = 0;
  int captures = 0;
  int pilot_takeovers = 0;
  // What the autopilot took from its link since the start.
  int motion_commands = 0, arm_commands = 0, capture_commands = 0;
  double last_motion_command_s = -1;
};

class SimulatedAutopilot {
 public:
  // Stands at `home_in_world` (ENU, metres; on `ground` when there is one). `origin`: of the ENU
  // frame, AMSL. Throws UsageError for invalid options.
  SimulatedAutopilot(const AutopilotOptions& options, const GeoPosition& origin,
                     const Eigen::Vector3d& home_in_world,
                     VehicleMotion::GroundHeight ground = nullptr);
  ~SimulatedAutopilot();

  void Receive(const MavFrame& frame);
  void Step(double dt_s);

  // What it sent since the last call, in order.
  std::vector<MavFrame> TakeFrames();
  std::vector<ShutterEvent> TakeShutterEvents();
  // A key that SETUP_SIGNING brought since the last call (32 bytes); empty: none.
  std::vector<std::uint8_t> TakeSigningKey();

  // A packet of the picture server, which is component 100, numbered among its others.
  void SendAsCamera(const MavFileTransferProtocol& message);

  // Where the reports say that pictures can be had: "http://127.0.0.1:41233/pictures". Needed for
  // file_url "http".
  void SetPictureUrl(const std::string& url);

  // Faults.
  void PilotSwitch(const std::string& mode);  // by name; throws UsageError for an unknown one
  void SetGpsGlitch(double east_m);
  void SetGpsLost(bool is_lost);
  void SetCameraFault(CameraFault fault);
  void SetGimbalStuck(bool is_stuck);
  void SetBatteryPercent(double percent);
  void SetWind(const WindOptions& wind);

  DroneTruth Truth() const;
  const AutopilotOptions& options() const;
  // Names of the modes that PilotSwitch knows.
  std::vector<std::string> ModeNames() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
