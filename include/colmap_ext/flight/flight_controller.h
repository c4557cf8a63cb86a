// State machine and driver together: packets, requests and the time go in; packets, journal records
// and pictures to fetch come out. No socket, no file, no clock: tests play whole flights with it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_ledger.h"
#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/flight/vehicle_driver.h"

namespace colmap_ext {

struct ControllerOutput {
  std::vector<MavFrame> frames;    // to be sent at once: heartbeats, questions, repetitions
  std::vector<Json> records;       // to be on disk ...
  std::vector<MavFrame> commands;  // ... before these are sent
  bool drops_commands = false;     // of earlier outputs, what waits for its records
  std::vector<FetchRequest> fetches;
  std::vector<std::string> texts;  // what the vehicle says to people
};

class FlightController {
 public:
  // Throws UsageError for bad options.
  FlightController(const FlightOptions& flight, const DriverOptions& driver, FlightLedger ledger);

  void Receive(const MavFrame& frame, double now_s);
  FlightReply Request(const FlightRequest& request, double now_s);
  void OnStored(int view_id, bool full_resolution, const std::string& file,
                const std::string& sha256, double now_s);
  void OnFetchFailed(int view_id, bool full_resolution, const std::string& reason, double now_s);
  // At least ten times a second.
  void Tick(double now_s);
  // A packet of a picture's transfer.
  void Send(const MavFileTransferProtocol& message, double now_s);
  ControllerOutput TakeOutput();

  const MissionMachine& machine() const { return machine_; }
  const VehicleState& vehicle() const { return driver_.vehicle(); }
  // GET /v1/status (docs/flight_api.md).
  Json Status(double now_s) const;

 private:
  void Advance(double now_s);
  void Collect(double now_s);

  FlightOptions options_;
  MissionMachine machine_;
  VehicleDriver driver_;
  ControllerOutput output_;
};

}  // namespace colmap_ext
