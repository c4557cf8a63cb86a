// Speaks MAVLink with one PX4 or ArduPilot vehicle: messages in, messages out, time by argument.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

struct DriverOptions {
  int system_id = 255;     // ours, [1, 255]; ArduPilot's failsafe listens to MAV_GCS_SYSID only
  int component_id = 190;  // ours, [1, 255]
  int vehicle_id = 0;      // system to fly, [0, 255]; 0: the first autopilot that is heard
  bool is_shadow = false;  // sends nothing at all
  double position_rate_hz = 5;  // asked of the vehicle, [1, 50]

  std::string Check() const;
};

// Section "Driver".
void BindOptions(OptionSet& set, DriverOptions* options);

// What happened since the last call.
struct DriverEvents {
  struct Answer {
    int id = 0;
    CommandOutcome outcome = CommandOutcome::kAccepted;
    std::string text;
  };
  std::vector<Answer> answers;
  std::optional<PreflightFacts> facts;
  std::vector<CaptureReport> captures;
  std::optional<int> picture_count;
  std::vector<std::string> texts;  // what the vehicle says to people
};

class VehicleDriver {
 public:
  explicit VehicleDriver(const DriverOptions& options);
  ~VehicleDriver();
  VehicleDriver(const VehicleDriver&) = delete;
  VehicleDriver& operator=(const VehicleDriver&) = delete;

  void Receive(const MavFrame& frame, double now_s);
  // `mission`: for the fence of kPreflight.
  void Execute(const FlightCommand& command, const FlightMission& mission,
               const FlightOptions& options, double now_s);
  void CancelMotion();
  // Sends what moves the vehicle, where its mode was heard later than the wish. To be called when
  // the mode that it is in was judged.
  void ReleaseMotion(double now_s);
  // A packet of a file's transfer, numbered among the others.
  void Send(const MavFileTransferProtocol& message);
  // Heartbeat once a second, repetitions, timeouts. At least ten times a second.
  void Tick(double now_s);

  std::vector<MavFrame> TakeFrames();
  DriverEvents TakeEvents();
  const VehicleState& vehicle() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
