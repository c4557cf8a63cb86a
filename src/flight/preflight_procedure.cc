#include "flight/preflight_procedure.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace colmap_ext {
namespace {

constexpr double kParameterS = 0.5;
constexpr int kParameterTries = 12;  // a fifth of all packets may be lost, each way
constexpr double kUploadS = 1.5;     // without a request (MAVLink's own timeout)
constexpr double kItemS = 0.4;
constexpr int kTries = 12;  // in a row, without progress

// PX4 puts an integer's bits into the float, ArduPilot its value.
double ValueOf(const MavParamValue& value, AutopilotStack stack) {
  const bool is_integer = value.param_type == MavParamType::kInt32 ||
                          value.param_type == MavParamType::kInt16 ||
                          value.param_type == MavParamType::kInt8;
  if (stack == AutopilotStack::kPx4 && is_integer) {
    return std::bit_cast<std::int32_t>(value.param_value);
  }
  return value.param_value;
}

}  // namespace

void PreflightProcedure::Start(const VehicleAddress& address, const std::vector<FenceCorner>& fence,
                               double now_s) {
  address_ = address;
  fence_ = fence;
  facts_ = {};
  messages_.clear();
  const std::vector<std::string> names = PreflightParameters(address.stack);
  wanted_ = {names.begin(), names.end()};
  phase_ = Phase::kParameters;
  tries_ = 0;
  AskParameters(now_s);
}

void PreflightProcedure::AskParameters(double now_s) {
  for (const std::string& name : wanted_) {
    MavParamRequestRead request;
    request.target_system = address_.system;
    request.target_component = address_.autopilot;
    request.param_index = -1;
    SetMavText(name, &request.param_id);
    messages_.emplace_back(request);
  }
  ++tries_;
  due_s_ = now_s + kParameterS;
}

void PreflightProcedure::OnParameter(const MavParamValue& value, double now_s) {
  const std::string name = MavText(value.param_id);
  if (wanted_.erase(name) == 0) return;
  facts_.parameters[name] = ValueOf(value, address_.stack);
  if (wanted_.empty()) BeginUpload(now_s);
}

void PreflightProcedure::BeginUpload(double now_s) {
  if (fence_.empty()) {
    Finish("");
    return;
  }
  phase_ = Phase::kUpload;
  item_ = -1;
  MavMissionCount count;
  count.target_system = address_.system;
  count.target_component = address_.autopilot;
  count.count = static_cast<std::uint16_t>(fence_.size());
  count.mission_type = MavMissionType::kFence;
  messages_.emplace_back(count);
  due_s_ = now_s + kUploadS;
}

MavMissionItemInt PreflightProcedure::Item(int index) const {
  const FenceCorner& corner = fence_[static_cast<std::size_t>(index)];
  MavMissionItemInt item;
  item.target_system = address_.system;
  item.target_component = address_.autopilot;
  item.seq = static_cast<std::uint16_t>(index);
  item.frame = MavCoordinateFrame::kGlobal;
  item.command = corner.is_exclusion ? MavCmd::kNavFencePolygonVertexExclusion
                                     : MavCmd::kNavFencePolygonVertexInclusion;
  item.param1 = static_cast<float>(corner.polygon_size);
  item.x = static_cast<std::int32_t>(std::lround(corner.place.lat_deg * 1e7));
  item.y = static_cast<std::int32_t>(std::lround(corner.place.lon_deg * 1e7));
  item.mission_type = MavMissionType::kFence;
  return item;
}

void PreflightProcedure::OnRequest(int sequence, MavMissionType type, double now_s) {
  if (phase_ != Phase::kUpload || type != MavMissionType::kFence) return;
  if (sequence < 0 || sequence >= static_cast<int>(fence_.size())) return;
  item_ = sequence;
  tries_ = 0;
  messages_.emplace_back(Item(sequence));
  due_s_ = now_s + kUploadS;
}

void PreflightProcedure::OnAck(const MavMissionAck& ack, double now_s) {
  if (phase_ != Phase::kUpload || ack.mission_type != MavMissionType::kFence) return;
  if (ack.type == MavMissionResult::kAccepted) {
    tries_ = 0;
    BeginReading(now_s);
    return;
  }
  Finish("the vehicle refuses the fence (MAV_MISSION_RESULT " +
         std::to_string(static_cast<int>(ack.type)) + ")");
}

void PreflightProcedure::BeginReading(double now_s) {
  phase_ = Phase::kReadCount;
  MavMissionRequestList list;
  list.target_system = address_.system;
  list.target_component = address_.autopilot;
  list.mission_type = MavMissionType::kFence;
  messages_.emplace_back(list);
  due_s_ = now_s + kUploadS;
}

void PreflightProcedure::OnCount(const MavMissionCount& count, double now_s) {
  if (phase_ != Phase::kReadCount || count.mission_type != MavMissionType::kFence) return;
  if (count.count != fence_.size()) {
    Finish("the vehicle has a fence of " + std::to_string(count.count) + " corners after " +
           std::to_string(fence_.size()) + " were written");
    return;
  }
  phase_ = Phase::kReadItems;
  item_ = 0;
  tries_ = 0;
  AskItem(now_s);
}

void PreflightProcedure::AskItem(double now_s) {
  MavMissionRequestInt request;
  request.target_system = address_.system;
  request.target_component = address_.autopilot;
  request.seq = static_cast<std::uint16_t>(item_);
  request.mission_type = MavMissionType::kFence;
  messages_.emplace_back(request);
  due_s_ = now_s + kItemS;
}

void PreflightProcedure::OnItem(const MavMissionItemInt& item, double now_s) {
  if (phase_ != Phase::kReadItems || item.mission_type != MavMissionType::kFence ||
      item.seq != item_) {
    return;
  }
  const MavMissionItemInt written = Item(item_);
  // Vehicles keep corners in float or integers: a centimetre or ten.
  if (item.command != written.command || std::abs(item.x - written.x) > 10 ||
      std::abs(item.y - written.y) > 10) {
    Finish("corner " + std::to_string(item_) + " of the fence did not come back as written");
    return;
  }
  tries_ = 0;
  if (++item_ < static_cast<int>(fence_.size())) {
    AskItem(now_s);
    return;
  }
  MavMissionAck ack;
  ack.target_system = address_.system;
  ack.target_component = address_.autopilot;
  ack.type = MavMissionResult::kAccepted;
  ack.mission_type = MavMissionType::kFence;
  messages_.emplace_back(ack);
  facts_.fence_uploaded = true;
  Finish("");
}

void PreflightProcedure::Finish(const std::string& fence_problem) {
  facts_.fence_problem = fence_problem;
  phase_ = Phase::kDone;
}

void PreflightProcedure::Receive(const MavFrame& frame, double now_s) {
  if (!IsRunning()) return;
  if (const auto value = UnpackMav<MavParamValue>(frame)) OnParameter(*value, now_s);
  if (const auto request = UnpackMav<MavMissionRequest>(frame)) {
    OnRequest(request->seq, request->mission_type, now_s);
  }
  if (const auto request = UnpackMav<MavMissionRequestInt>(frame)) {
    OnRequest(request->seq, request->mission_type, now_s);
  }
  if (const auto ack = UnpackMav<MavMissionAck>(frame)) OnAck(*ack, now_s);
  if (const auto count = UnpackMav<MavMissionCount>(frame)) OnCount(*count, now_s);
  if (const auto item = UnpackMav<MavMissionItemInt>(frame)) OnItem(*item, now_s);
}

void PreflightProcedure::Tick(double now_s) {
  if (!IsRunning() || now_s < due_s_) return;
  if (phase_ == Phase::kParameters) {
    if (tries_ < kParameterTries) {
      AskParameters(now_s);
    } else {
      tries_ = 0;
      BeginUpload(now_s);
    }
    return;
  }
  if (++tries_ > kTries) {
    Finish("the vehicle does not answer about its fence");
  } else if (phase_ == Phase::kUpload && item_ + 1 == static_cast<int>(fence_.size())) {
    messages_.emplace_back(Item(item_));  // its acknowledgement was lost, or it was
    due_s_ = now_s + kUploadS;
  } else if (phase_ == Phase::kUpload) {
    BeginUpload(now_s);
  } else if (phase_ == Phase::kReadCount) {
    BeginReading(now_s);
  } else {
    AskItem(now_s);
  }
}

}  // namespace colmap_ext
