#include "sim/drone_missions.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace colmap_ext {
namespace {

bool IsFenceVertex(MavCmd command) {
  return command == MavCmd::kNavFencePolygonVertexInclusion ||
         command == MavCmd::kNavFencePolygonVertexExclusion;
}

bool IsFenceItem(MavCmd command) {
  return IsFenceVertex(command) || command == MavCmd::kNavFenceCircleInclusion ||
         command == MavCmd::kNavFenceCircleExclusion || command == MavCmd::kNavFenceReturnPoint;
}

constexpr MavCmd kMissionCommands[] = {MavCmd::kNavWaypoint,
                                       MavCmd::kNavReturnToLaunch,
                                       MavCmd::kNavLand,
                                       MavCmd::kNavTakeoff,
                                       MavCmd::kNavDelay,
                                       MavCmd::kConditionYaw,
                                       MavCmd::kDoChangeSpeed,
                                       MavCmd::kDoDigicamControl,
                                       MavCmd::kDoMountControl,
                                       MavCmd::kSetCameraMode,
                                       MavCmd::kDoGimbalManagerPitchyaw,
                                       MavCmd::kDoGimbalManagerConfigure,
                                       MavCmd::kImageStartCapture,
                                       MavCmd::kImageStopCapture};

}  // namespace

DroneMissions::DroneMissions(AutopilotPersonality personality, Send send)
    : personality_(personality), send_(std::move(send)) {}

void DroneMissions::SetHome(const MavMissionItemInt& home) {
  auto& mission = lists_[0];
  if (personality_ != AutopilotPersonality::kArduPilot) return;
  if (mission.empty()) mission.resize(1);
  mission[0] = home;
}

const std::vector<MavMissionItemInt>& DroneMissions::Items(MavMissionType type) const {
  return lists_.at(static_cast<std::size_t>(type));
}

std::vector<MavMissionType> DroneMissions::TakeChanges() { return std::exchange(changes_, {}); }

void DroneMissions::Receive(const MavFrame& frame, double time_s) {
  if (const auto count = UnpackMav<MavMissionCount>(frame)) Begin(*count, frame, time_s);
  if (const auto item = UnpackMav<MavMissionItemInt>(frame)) Take(*item, frame, time_s);
  if (const auto request = UnpackMav<MavMissionRequestInt>(frame)) {
    SendItem(request->seq, request->mission_type, frame);
  }
  if (const auto request = UnpackMav<MavMissionRequest>(frame)) {
    SendItem(request->seq, request->mission_type, frame);
  }
  if (const auto list = UnpackMav<MavMissionRequestList>(frame)) {
    if (list->mission_type > MavMissionType::kRally) {
      return Acknowledge(MavMissionResult::kUnsupported, list->mission_type, frame);
    }
    MavMissionCount count;
    count.target_system = frame.system_id;
    count.target_component = frame.component_id;
    count.count = static_cast<std::uint16_t>(Items(list->mission_type).size());
    count.mission_type = list->mission_type;
    send_(count);
  }
  if (const auto clear = UnpackMav<MavMissionClearAll>(frame)) {
    Clear(clear->mission_type);
    Acknowledge(MavMissionResult::kAccepted, clear->mission_type, frame);
  }
  if (const auto ack = UnpackMav<MavMissionAck>(frame)) {
    if (ack->type == MavMissionResult::kOperationCancelled) is_receiving_ = false;
  }
}

void DroneMissions::Clear(MavMissionType type) {
  for (const auto each :
       {MavMissionType::kMission, MavMissionType::kFence, MavMissionType::kRally}) {
    if (type != each && type != MavMissionType::kAll) continue;
    auto& list = lists_[static_cast<std::size_t>(each)];
    const bool keeps_home =
        each == MavMissionType::kMission && personality_ == AutopilotPersonality::kArduPilot;
    list.resize(keeps_home ? std::min<std::size_t>(1, list.size()) : 0);
    changes_.push_back(each);
  }
}

void DroneMissions::Begin(const MavMissionCount& count, const MavFrame& frame, double time_s) {
  if (count.mission_type > MavMissionType::kRally) {
    return Acknowledge(MavMissionResult::kUnsupported, count.mission_type, frame);
  }
  if (count.count > 700) {
    return Acknowledge(MavMissionResult::kNoSpace, count.mission_type, frame);
  }
  peer_ = frame;
  type_ = count.mission_type;
  count_ = count.count;
  received_.clear();
  is_receiving_ = true;
  if (count_ == 0) {
    Clear(type_);
    return Finish(MavMissionResult::kAccepted);
  }
  repeats_ = 0;
  Request(time_s);
}

void DroneMissions::Request(double time_s) {
  repeat_at_s_ = time_s + kRepeat_s;
  const auto seq = static_cast<std::uint16_t>(received_.size());
  if (personality_ == AutopilotPersonality::kArduPilot || seq % 2 == 1) {
    MavMissionRequest request;
    request.target_system = peer_.system_id;
    request.target_component = peer_.component_id;
    request.seq = seq;
    request.mission_type = type_;
    send_(request);
  } else {
    MavMissionRequestInt request;
    request.target_system = peer_.system_id;
    request.target_component = peer_.component_id;
    request.seq = seq;
    request.mission_type = type_;
    send_(request);
  }
}

void DroneMissions::Take(const MavMissionItemInt& item, const MavFrame& frame, double time_s) {
  if (!is_receiving_) {
    // The last acknowledgement was lost: the sender repeats its last item.
    if (item.mission_type == type_ && item.seq + 1 == count_) {
      Acknowledge(MavMissionResult::kAccepted, type_, frame);
    }
    return;
  }
  if (item.mission_type != type_ || item.seq != received_.size()) return;  // repeated or early
  const MavMissionResult result = CheckItem(item);
  if (result != MavMissionResult::kAccepted) return Finish(result);
  received_.push_back(item);
  repeats_ = 0;
  if (received_.size() < count_) return Request(time_s);
  const MavMissionResult whole = CheckList();
  if (whole == MavMissionResult::kAccepted) {
    auto& list = lists_[static_cast<std::size_t>(type_)];
    const bool keeps_home = type_ == MavMissionType::kMission && !list.empty() &&
                            personality_ == AutopilotPersonality::kArduPilot;
    const MavMissionItemInt home = keeps_home ? list[0] : MavMissionItemInt();
    list = received_;
    if (keeps_home) list[0] = home;
    changes_.push_back(type_);
  }
  Finish(whole);
}

MavMissionResult DroneMissions::CheckItem(const MavMissionItemInt& item) const {
  if (type_ == MavMissionType::kFence && !IsFenceItem(item.command)) {
    return MavMissionResult::kUnsupported;
  }
  if (type_ == MavMissionType::kRally && item.command != MavCmd::kNavRallyPoint) {
    return MavMissionResult::kUnsupported;
  }
  if (type_ == MavMissionType::kMission &&
      std::ranges::find(kMissionCommands, item.command) == std::end(kMissionCommands)) {
    return MavMissionResult::kUnsupported;
  }
  if (std::abs(item.x) > 900'000'000) return MavMissionResult::kInvalidParam5X;
  if (std::abs(item.y) > 1'800'000'000) return MavMissionResult::kInvalidParam6Y;
  if (!std::isfinite(item.z)) return MavMissionResult::kInvalidParam7;
  return MavMissionResult::kAccepted;
}

// Every polygon must have all the vertices that its items announce.
MavMissionResult DroneMissions::CheckList() const {
  if (type_ != MavMissionType::kFence) return MavMissionResult::kAccepted;
  for (std::size_t i = 0; i < received_.size();) {
    if (!IsFenceVertex(received_[i].command)) {
      ++i;
      continue;
    }
    const auto vertices = static_cast<std::size_t>(std::max(0.0F, received_[i].param1));
    if (vertices < 3 || i + vertices > received_.size()) return MavMissionResult::kInvalidParam1;
    for (std::size_t k = i; k < i + vertices; ++k) {
      const bool same = received_[k].command == received_[i].command &&
                        received_[k].param1 == received_[i].param1;
      if (!same) return MavMissionResult::kInvalidParam1;
    }
    i += vertices;
  }
  return MavMissionResult::kAccepted;
}

void DroneMissions::Finish(MavMissionResult result) {
  is_receiving_ = false;
  Acknowledge(result, type_, peer_);
}

void DroneMissions::Acknowledge(MavMissionResult result, MavMissionType type,
                                const MavFrame& frame) {
  MavMissionAck ack;
  ack.target_system = frame.system_id;
  ack.target_component = frame.component_id;
  ack.type = result;
  ack.mission_type = type;
  send_(ack);
}

void DroneMissions::SendItem(std::uint16_t seq, MavMissionType type, const MavFrame& frame) {
  if (type > MavMissionType::kRally) {
    return Acknowledge(MavMissionResult::kUnsupported, type, frame);
  }
  const auto& list = Items(type);
  if (seq >= list.size()) return Acknowledge(MavMissionResult::kInvalidSequence, type, frame);
  MavMissionItemInt item = list[seq];
  item.target_system = frame.system_id;
  item.target_component = frame.component_id;
  item.seq = seq;
  item.current = seq == 0 ? 1 : 0;
  item.mission_type = type;
  send_(item);
}

void DroneMissions::Step(double time_s) {
  if (!is_receiving_ || time_s < repeat_at_s_) return;
  if (++repeats_ > kRepeats) return Finish(MavMissionResult::kOperationCancelled);
  Request(time_s);
}

}  // namespace colmap_ext
