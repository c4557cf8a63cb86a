// A ground station for tests: talks to a SimulatedAutopilot by packets only, and keeps what came.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/sim/autopilot.h"

namespace colmap_ext {

inline constexpr auto kPx4 = AutopilotPersonality::kPx4;
inline constexpr auto kArduPilot = AutopilotPersonality::kArduPilot;

}  // namespace colmap_ext

namespace colmap_ext::test {

inline constexpr GeoPosition kPlace{47.4, 8.5, 500};

// No wind, no GPS error, ready early: tests that want trouble ask for it.
inline AutopilotOptions QuietDrone(AutopilotPersonality personality) {
  AutopilotOptions options;
  options.personality = personality;
  options.motion.wind = {0, 0, 0};
  options.gps.gps_bias_m = options.gps.gps_noise_m = 0;
  options.gimbal.gimbal_jitter_deg = 0;
  options.prearm_ready_s = 3;
  options.estimator_ready_s = 4;
  return options;
}

class AutopilotPeer {
 public:
  explicit AutopilotPeer(const AutopilotOptions& options)
      : drone(options, kPlace, Eigen::Vector3d::Zero()),
        is_px4(options.personality == AutopilotPersonality::kPx4) {}

  // Sends heartbeats once a second unless `keeps_heartbeat` is off, and lets time pass.
  void Run(double seconds) {
    for (double end = time_s + seconds; time_s < end - 1e-9; time_s += 0.05) {
      if (keeps_heartbeat && time_s >= next_heartbeat_s) {
        MavHeartbeat heartbeat;
        heartbeat.type = MavType::kGcs;
        heartbeat.autopilot = MavAutopilot::kInvalid;
        Send(heartbeat);
        next_heartbeat_s = time_s + 1;
      }
      drone.Step(0.05);
      Collect();
    }
  }
  // Until `is_done`; false when it does not come within `most_s`.
  bool RunUntil(const std::function<bool()>& is_done, double most_s) {
    for (const double end = time_s + most_s; time_s < end;) {
      if (is_done()) return true;
      Run(0.1);
    }
    return is_done();
  }

  template <typename Message>
  void Send(const Message& message) {
    drone.Receive(sender.Next(message));
    Collect();
  }
  template <typename Message>
  std::optional<Message> Last() const {
    const auto found = last.find(Message::kId);
    return found == last.end() ? std::nullopt : UnpackMav<Message>(found->second);
  }
  template <typename Message>
  int Count() const {
    const auto found = counts.find(Message::kId);
    return found == counts.end() ? 0 : found->second;
  }

  // The answer to a command; nothing when none came at once.
  std::optional<MavResult> Command(MavCmd id, std::array<float, 7> p,
                                   std::uint8_t component = MavComponent::kAutopilot) {
    MavCommandLong command;
    command.target_system = 1;
    command.target_component = component;
    command.command = id;
    command.param1 = p[0];
    command.param2 = p[1];
    command.param3 = p[2];
    command.param4 = p[3];
    command.param5 = p[4];
    command.param6 = p[5];
    command.param7 = p[6];
    last.erase(MavCommandAck::kId);
    Send(command);
    return ResultOf(id);
  }
  std::optional<MavResult> Reposition(const Eigen::Vector3d& enu, double z,
                                      MavCoordinateFrame frame, double yaw = 0, float flags = 1) {
    MavCommandInt command;
    const GeoPosition place = GeoFromEnu(kPlace, enu);
    command.target_system = 1;
    command.target_component = 1;
    command.command = MavCmd::kDoReposition;
    command.frame = frame;
    command.param1 = -1;
    command.param2 = flags;
    command.param4 = static_cast<float>(yaw);
    command.x = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
    command.y = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
    command.z = static_cast<float>(z);
    last.erase(MavCommandAck::kId);
    Send(command);
    return ResultOf(MavCmd::kDoReposition);
  }
  // As each stack's driver would: PX4 AMSL, ArduPilot a height above home.
  std::optional<MavResult> FlyTo(const Eigen::Vector3d& enu, double yaw = 0) {
    return is_px4 ? Reposition(enu, kPlace.height_m + enu.z(), MavCoordinateFrame::kGlobal, yaw)
                  : Reposition(enu, enu.z(), MavCoordinateFrame::kGlobalRelativeAltInt, yaw);
  }
  std::optional<MavResult> SetMode(Px4MainMode main, Px4AutoMode sub) {
    return Command(MavCmd::kDoSetMode,
                   {1, static_cast<float>(main), static_cast<float>(sub), 0, 0, 0, 0});
  }
  std::optional<MavResult> SetMode(ArduCopterMode mode) {
    return Command(MavCmd::kDoSetMode, {1, static_cast<float>(mode), 0, 0, 0, 0, 0});
  }
  std::optional<MavResult> Arm() {
    return Command(MavCmd::kComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0});
  }
  // Ready, armed and hovering at this height above home.
  bool GoUp(float height_m) {
    Run(is_px4 ? 8 : 25);
    if (!is_px4 && SetMode(ArduCopterMode::kGuided) != MavResult::kAccepted) return false;
    if (Arm() != MavResult::kAccepted) return false;
    const float z = is_px4 ? static_cast<float>(kPlace.height_m) + height_m : height_m;
    if (Command(MavCmd::kNavTakeoff, {0, 0, 0, NAN, NAN, NAN, z}) != MavResult::kAccepted) {
      return false;
    }
    return RunUntil(
        [&] {
          const DroneTruth truth = drone.Truth();
          return std::abs(truth.motion.position.z() - static_cast<double>(height_m)) < 0.3 &&
                 truth.motion.velocity.norm() < 0.2 && truth.mode != "TAKEOFF";
        },
        40);
  }
  std::optional<MavResult> ResultOf(MavCmd id) const {
    const auto ack = Last<MavCommandAck>();
    if (!ack || ack->command != id) return std::nullopt;
    return ack->result;
  }
  Eigen::Vector3d Position() const { return drone.Truth().motion.position; }
  std::string Mode() const { return drone.Truth().mode; }

  SimulatedAutopilot drone;
  bool is_px4;
  bool keeps_heartbeat = true;
  double time_s = 0, next_heartbeat_s = 0;
  MavSender sender{255, 190};
  std::map<std::uint32_t, MavFrame> last;
  std::map<std::uint32_t, int> counts;
  std::vector<std::string> texts;
  std::vector<ShutterEvent> pictures;
  std::vector<MavFrame> frames;  // all of them

 private:
  void Collect() {
    for (const MavFrame& frame : drone.TakeFrames()) {
      // The camera's heartbeat is not the vehicle's.
      const bool is_camera = frame.component_id == MavComponent::kCamera;
      if (is_camera && frame.message_id == MavHeartbeat::kId) continue;
      last[frame.message_id] = frame;
      ++counts[frame.message_id];
      frames.push_back(frame);
      if (const auto text = UnpackMav<MavStatustext>(frame)) texts.push_back(MavText(text->text));
    }
    for (const ShutterEvent& event : drone.TakeShutterEvents()) pictures.push_back(event);
  }
};

}  // namespace colmap_ext::test
