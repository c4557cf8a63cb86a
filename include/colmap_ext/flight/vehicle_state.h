// What the daemon knows about the vehicle, in its own words: no MAVLink here.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "colmap_ext/geom/geodesy.h"

namespace colmap_ext {

enum class AutopilotStack { kUnknown, kPx4, kArduPilot };

// Flight modes as far as the daemon tells them apart.
enum class VehicleMode {
  kUnknown,
  kPilot,    // any mode that a person flies, and all that are not below
  kGuided,   // takes our targets and hovers between them: PX4 Hold, ArduPilot GUIDED
  kBrake,    // ArduPilot: stopped by us
  kTakeoff,  // PX4 only
  kMission,
  kReturn,
  kLand,
};

enum class LandedState { kUnknown, kOnGround, kTakingOff, kInAir, kLanding };

struct GimbalState {
  double heard_s = -std::numeric_limits<double>::infinity();
  double pitch_rad = 0;  // above the horizon
  double yaw_rad = 0;    // from north
  bool is_v2 = true;     // reported by the gimbal protocol of today
};

struct VehicleState {
  // When the autopilot was last heard, on the daemon's clock; -infinity: never.
  double heard_s = -std::numeric_limits<double>::infinity();
  AutopilotStack stack = AutopilotStack::kUnknown;
  bool is_identified = false;  // stack, version, home and position are known
  std::string description;     // "PX4 1.15.0"
  bool is_armed = false;
  VehicleMode mode = VehicleMode::kUnknown;
  std::string mode_name;
  double mode_heard_s = -std::numeric_limits<double>::infinity();
  LandedState landed = LandedState::kUnknown;

  // Heights above mean sea level. Absent until the vehicle told.
  std::optional<GeoPosition> position;
  double position_heard_s = -std::numeric_limits<double>::infinity();
  double relative_height_m = 0;                               // above home
  Eigen::Vector3d velocity_in_enu = Eigen::Vector3d::Zero();  // m/s
  double yaw_rad = 0;                                         // of the body, from north
  double roll_rad = 0;                                        // positive: right side down
  double pitch_rad = 0;                                       // positive: nose up
  std::optional<GeoPosition> home;                            // above mean sea level
  std::optional<GeoPosition> target;  // where the autopilot says that it flies to

  int gps_fix = 0;  // GPS_FIX_TYPE: 3 is three-dimensional, 6 RTK fixed
  int satellites = 0;
  std::optional<double> sigma_horizontal_m;
  std::optional<double> sigma_vertical_m;
  std::optional<double> ellipsoid_height_m;  // of the receiver

  std::optional<bool> is_estimate_good;  // EKF
  std::optional<bool> is_prearm_good;
  bool is_fence_breached = false;
  std::optional<double> battery_percent;  // left

  std::optional<GimbalState> gimbal;  // absent: nothing reports its attitude
};

const char* Name(AutopilotStack stack);
const char* Name(VehicleMode mode);

}  // namespace colmap_ext
