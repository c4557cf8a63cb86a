// Asks the vehicle what CheckPreflight wants to know: parameters, camera and gimbal, and the fence,
// which is written and read back. Moves nothing. Sans-IO.
#pragma once

#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "colmap_ext/flight/preflight.h"
#include "colmap_ext/mavlink/codec.h"
#include "flight/autopilot_dialect.h"

namespace colmap_ext {

using PreflightMessage = std::variant<MavParamRequestRead, MavMissionCount, MavMissionItemInt,
                                      MavMissionRequestList, MavMissionRequestInt, MavMissionAck>;

struct FenceCorner {
  GeoPosition place;
  int polygon_size = 0;  // corners of its polygon
  bool is_exclusion = false;
};

class PreflightProcedure {
 public:
  // `fence`: the corners of one polygon after the other; empty: none is written.
  void Start(const VehicleAddress& address, const std::vector<FenceCorner>& fence, double now_s);
  bool IsRunning() const { return phase_ != Phase::kIdle && phase_ != Phase::kDone; }
  bool IsDone() const { return phase_ == Phase::kDone; }
  void Receive(const MavFrame& frame, double now_s);
  void Tick(double now_s);
  std::vector<PreflightMessage> TakeMessages() { return std::exchange(messages_, {}); }
  // Parameters and fence; camera and gimbal are for the caller to fill in.
  PreflightFacts facts() const { return facts_; }

 private:
  enum class Phase { kIdle, kParameters, kUpload, kReadCount, kReadItems, kDone };

  void OnParameter(const MavParamValue& value, double now_s);
  void OnRequest(int sequence, MavMissionType type, double now_s);
  void OnAck(const MavMissionAck& ack, double now_s);
  void OnCount(const MavMissionCount& count, double now_s);
  void OnItem(const MavMissionItemInt& item, double now_s);
  void AskParameters(double now_s);
  void BeginUpload(double now_s);
  void BeginReading(double now_s);
  void AskItem(double now_s);
  void Finish(const std::string& fence_problem);
  MavMissionItemInt Item(int index) const;

  Phase phase_ = Phase::kIdle;
  VehicleAddress address_;
  std::vector<FenceCorner> fence_;
  std::set<std::string> wanted_;
  PreflightFacts facts_;
  std::vector<PreflightMessage> messages_;
  int tries_ = 0;
  double due_s_ = 0;
  int item_ = 0;
};

}  // namespace colmap_ext
