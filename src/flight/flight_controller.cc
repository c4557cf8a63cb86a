#include "colmap_ext/flight/flight_controller.h"

#include <cmath>
#include <iterator>
#include <utility>

#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {
namespace {

template <typename T>
void MoveTo(std::vector<T>&& from, std::vector<T>* to) {
  to->insert(to->end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

Json GeoToJson(const GeoPosition& position) {
  return {{"lat", position.lat_deg}, {"lon", position.lon_deg}, {"amsl_m", position.height_m}};
}

template <typename T>
void SetIfThere(const char* key, const std::optional<T>& value, Json* json) {
  if (value) (*json)[key] = *value;
}

Json VehicleToJson(const VehicleState& vehicle, const FlightMission& mission, double now_s) {
  Json json = {{"stack", Name(vehicle.stack)},
               {"description", vehicle.description},
               {"armed", vehicle.is_armed},
               {"mode", vehicle.mode_name},
               {"landed", vehicle.landed == LandedState::kOnGround},
               {"gps_fix", vehicle.gps_fix},
               {"fence_breached", vehicle.is_fence_breached}};
  if (std::isfinite(vehicle.heard_s)) json["silent_s"] = now_s - vehicle.heard_s;
  if (vehicle.position) {
    json["position"] = GeoToJson(*vehicle.position);
    json["relative_height_m"] = vehicle.relative_height_m;
    json["speed_m_s"] = vehicle.velocity_in_enu.norm();
    json["yaw_deg"] = RadToDeg(vehicle.yaw_rad);
    if (mission.is_vouched || !mission.surface_path.empty()) {
      const Eigen::Vector3d world = mission.WorldFromAmsl(*vehicle.position);
      json["position_enu_m"] = {world.x(), world.y(), world.z()};
    }
  }
  if (vehicle.home) json["home"] = GeoToJson(*vehicle.home);
  if (vehicle.gimbal) json["gimbal_pitch_deg"] = RadToDeg(vehicle.gimbal->pitch_rad);
  SetIfThere("battery_percent", vehicle.battery_percent, &json);
  SetIfThere("sigma_h_m", vehicle.sigma_horizontal_m, &json);
  SetIfThere("sigma_v_m", vehicle.sigma_vertical_m, &json);
  SetIfThere("estimate_good", vehicle.is_estimate_good, &json);
  return json;
}

Json ViewsToJson(const FlightMission& mission, const FlightLedger& ledger) {
  Json views = Json::array();
  for (const FlightStop& stop : mission.stops) {
    if (stop.view_id < 0) continue;
    Json view = {{"view_id", stop.view_id}, {"photo", stop.photo}};
    const auto found = ledger.views.find(stop.view_id);
    const ViewStatus status =
        found == ledger.views.end() ? ViewStatus::kPending : found->second.status;
    view["status"] = Name(status);
    if (status == ViewStatus::kFailed) view["reason"] = found->second.reason;
    if (status == ViewStatus::kCaptured || status == ViewStatus::kStored) {
      view["index"] = found->second.capture.record.index;
    }
    if (mission.full_resolution && status == ViewStatus::kStored) {
      view["full_stored"] = found->second.full_stored;
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace

FlightController::FlightController(const FlightOptions& flight, const DriverOptions& driver,
                                   FlightLedger ledger)
    : options_(flight), machine_(flight, std::move(ledger), driver.is_shadow), driver_(driver) {
  Collect(0);
}

void FlightController::Receive(const MavFrame& frame, double now_s) {
  driver_.Receive(frame, now_s);
  Advance(now_s);
}

FlightReply FlightController::Request(const FlightRequest& request, double now_s) {
  FlightReply reply = machine_.Request(request, now_s);
  Collect(now_s);
  return reply;
}

void FlightController::OnStored(int view_id, bool full_resolution, const std::string& file,
                                const std::string& sha256, double now_s) {
  machine_.OnStored(view_id, full_resolution, file, sha256, now_s);
  Collect(now_s);
}

void FlightController::OnFetchFailed(int view_id, bool full_resolution, const std::string& reason,
                                     double now_s) {
  machine_.OnFetchFailed(view_id, full_resolution, reason, now_s);
  Collect(now_s);
}

void FlightController::Tick(double now_s) {
  driver_.Tick(now_s);
  Advance(now_s);
}

void FlightController::Send(const MavFileTransferProtocol& message, double now_s) {
  driver_.Send(message);
  Collect(now_s);
}

void FlightController::Advance(double now_s) {
  DriverEvents events = driver_.TakeEvents();
  for (const CaptureReport& report : events.captures) machine_.OnCapture(report, now_s);
  if (events.picture_count) machine_.OnPictureCount(*events.picture_count, now_s);
  if (events.facts) machine_.OnPreflightFacts(*events.facts, now_s);
  for (const DriverEvents::Answer& answer : events.answers) {
    machine_.OnCommand(answer.id, answer.outcome, answer.text, now_s);
  }
  MoveTo(std::move(events.texts), &output_.texts);
  machine_.Advance(driver_.vehicle(), now_s);
  Collect(now_s);
}

// Commands wait for their records; what the driver sends by itself does not.
void FlightController::Collect(double now_s) {
  MoveTo(driver_.TakeFrames(), &output_.frames);
  MachineOutput made = machine_.TakeOutput();
  if (made.cancel_motion) {
    driver_.CancelMotion();
    output_.drops_commands = true;
    output_.commands.clear();
  }
  for (const FlightCommand& command : made.commands) {
    driver_.Execute(command, machine_.mission(), options_, now_s);
  }
  driver_.ReleaseMotion(now_s);
  MoveTo(driver_.TakeFrames(), &output_.commands);
  MoveTo(std::move(made.records), &output_.records);
  MoveTo(std::move(made.fetches), &output_.fetches);
}

ControllerOutput FlightController::TakeOutput() { return std::exchange(output_, {}); }

Json FlightController::Status(double now_s) const {
  const FlightMission& mission = machine_.mission();
  Json items = Json::array();
  for (const PreflightItem& item : machine_.preflight()) {
    items.push_back({{"name", item.name},
                     {"good", item.is_good},
                     {"failsafe", item.is_failsafe},
                     {"text", item.text}});
  }
  Json unclaimed = Json::array();
  for (const auto& [index, report] : machine_.ledger().others) unclaimed.push_back(index);
  return {{"state", Name(machine_.state())},
          {"reason", machine_.reason()},
          {"revision", mission.stops.empty() ? 0 : mission.revision},
          {"next_stop", machine_.next_stop()},
          {"stops", mission.stops.size()},
          {"flights", machine_.ledger().flights},
          {"vehicle", VehicleToJson(vehicle(), mission, now_s)},
          {"views", ViewsToJson(mission, machine_.ledger())},
          {"other_pictures", unclaimed},
          {"preflight", items}};
}

}  // namespace colmap_ext
