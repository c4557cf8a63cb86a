// The vehicle's side of MAVLink's mission protocol: mission, fence and rally lists, up and down.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/sim/autopilot.h"

namespace colmap_ext {

// ArduPilot asks by MISSION_REQUEST (40); PX4 mixes that with MISSION_REQUEST_INT (51).
class DroneMissions {
 public:
  using Message = std::variant<MavMissionRequest, MavMissionRequestInt, MavMissionAck,
                               MavMissionCount, MavMissionItemInt>;
  using Send = std::function<void(const Message&)>;

  DroneMissions(AutopilotPersonality personality, Send send);

  // ArduPilot keeps home as item 0 of the mission.
  void SetHome(const MavMissionItemInt& home);

  void Receive(const MavFrame& frame, double time_s);
  void Step(double time_s);  // repeats requests that were not answered

  const std::vector<MavMissionItemInt>& Items(MavMissionType type) const;
  // Lists that were replaced since the last call.
  std::vector<MavMissionType> TakeChanges();

 private:
  void Begin(const MavMissionCount& count, const MavFrame& frame, double time_s);
  void Take(const MavMissionItemInt& item, const MavFrame& frame, double time_s);
  void SendItem(std::uint16_t seq, MavMissionType type, const MavFrame& frame);
  void Request(double time_s);
  void Finish(MavMissionResult result);
  void Acknowledge(MavMissionResult result, MavMissionType type, const MavFrame& frame);
  void Clear(MavMissionType type);
  MavMissionResult CheckItem(const MavMissionItemInt& item) const;
  MavMissionResult CheckList() const;

  static constexpr double kRepeat_s = 0.25;
  static constexpr int kRepeats = 10;

  AutopilotPersonality personality_;
  Send send_;
  std::array<std::vector<MavMissionItemInt>, 3> lists_;
  std::vector<MavMissionType> changes_;

  // The upload at work.
  bool is_receiving_ = false;
  MavMissionType type_{};
  std::uint16_t count_ = 0;
  std::vector<MavMissionItemInt> received_;
  MavFrame peer_;
  double repeat_at_s_ = 0;
  int repeats_ = 0;
};

}  // namespace colmap_ext
