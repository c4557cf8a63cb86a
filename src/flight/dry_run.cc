#include "colmap_ext/flight/dry_run.h"

#include <algorithm>
#include <cstdio>

#include "flight/autopilot_dialect.h"

namespace colmap_ext {
namespace {

std::string TextOf(const MavCommandLong& m) {
  char text[240];
  std::snprintf(text, sizeof text, "COMMAND_LONG %d (%.7g, %.7g, %.7g, %.7g, %.7g, %.7g, %.7g)",
                static_cast<int>(m.command), m.param1, m.param2, m.param3, m.param4, m.param5,
                m.param6, m.param7);
  return text;
}

std::string TextOf(const MavCommandInt& m) {
  char text[240];
  std::snprintf(text, sizeof text,
                "COMMAND_INT %d (%.7g, %.7g, %.7g, %.7g) lat %.7f lon %.7f amsl %.2f",
                static_cast<int>(m.command), m.param1, m.param2, m.param3, m.param4, m.x * 1e-7,
                m.y * 1e-7, static_cast<double>(m.z));
  return text;
}

class Listing {
 public:
  explicit Listing(AutopilotStack stack) { address_.stack = stack; }

  void Add(const std::string& why, const FlightCommand& command) {
    for (const MavStep& step : StepsOf(command, address_)) {
      char number[16];
      std::snprintf(number, sizeof number, "%4d  ", ++count_);
      std::string name = why;
      name.resize(std::max<std::size_t>(name.size(), 14), ' ');
      text_ += number + name + "  " +
               std::visit([](const auto& message) { return TextOf(message); }, step.message) + "\n";
    }
    if (command.kind == CommandKind::kAim) address_.owns_gimbal = true;
  }

  const std::string& text() const { return text_; }

 private:
  VehicleAddress address_;
  int count_ = 0;
  std::string text_;
};

FlightCommand Plain(CommandKind kind) {
  FlightCommand command;
  command.kind = kind;
  return command;
}

void AddStop(const FlightMission& mission, const FlightStop& stop, double home_z_m, int* sequence,
             Listing* list) {
  const std::string name = stop.view_id >= 0 ? "view " + std::to_string(stop.view_id) : "way";
  FlightCommand go = Plain(CommandKind::kGoTo);
  go.target = mission.AmslFromWorld(stop.position);
  go.relative_height_m = stop.position.z() - home_z_m;
  go.yaw_rad = stop.direction.yaw_rad;
  go.speed_m_s = mission.speed_m_s;
  list->Add(name, go);
  if (stop.view_id < 0) return;
  FlightCommand aim = Plain(CommandKind::kAim);
  aim.pitch_rad = stop.direction.pitch_rad;
  list->Add(name + " aim", aim);
  FlightCommand capture = Plain(CommandKind::kCapture);
  capture.sequence = (*sequence)++;
  list->Add(name + " photo", capture);
}

}  // namespace

std::string DryRunText(const FlightMission& mission, AutopilotStack stack,
                       const Eigen::Vector3d& home, double takeoff_height_m) {
  Listing list(stack);
  list.Add("guided mode", Plain(CommandKind::kGuided));
  list.Add("arm", Plain(CommandKind::kArm));
  FlightCommand takeoff = Plain(CommandKind::kTakeoff);
  takeoff.relative_height_m = takeoff_height_m;
  if (!mission.stops.empty()) {
    takeoff.relative_height_m =
        std::max(takeoff_height_m, mission.stops.front().position.z() - home.z());
  }
  takeoff.target =
      mission.AmslFromWorld(home + takeoff.relative_height_m * Eigen::Vector3d::UnitZ());
  list.Add("take-off", takeoff);
  int sequence = 1;
  for (const FlightStop& stop : mission.stops) {
    AddStop(mission, stop, home.z(), &sequence, &list);
  }
  if (mission.at_end != AtEnd::kHold) {
    const bool lands = mission.at_end == AtEnd::kLand;
    list.Add(lands ? "land" : "return", Plain(lands ? CommandKind::kLand : CommandKind::kReturn));
  }
  return list.text();
}

}  // namespace colmap_ext
