// MAVLink messages to the state of the vehicle: MAVLink's border, where NED ends.
#pragma once

#include <optional>
#include <string>

#include "colmap_ext/flight/flight_ledger.h"
#include "colmap_ext/flight/vehicle_state.h"
#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

// Takes in what `frame` says about the vehicle. False: it says nothing of the kind.
bool UpdateVehicle(const MavFrame& frame, double now_s, VehicleState* vehicle);

// The camera's report of a picture, or ArduPilot's CAMERA_FEEDBACK; nothing for other messages.
// What the message lacks comes from `vehicle`.
std::optional<CaptureReport> ReadCapture(const MavFrame& frame, const VehicleState& vehicle);

// Attitude of a camera (earth NED from forward, right, down) as cam_from_enu; nothing for a
// quaternion that is none. q: w first.
std::optional<Eigen::Quaterniond> CamFromEnu(const std::array<float, 4>& q);

// "2026-11-22T08:00:00.123456Z" of microseconds since 1970; empty for 0.
std::string IsoTime(std::uint64_t microseconds);

}  // namespace colmap_ext
