#include "sim/drone_parameters.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {

DroneParameters::DroneParameters(AutopilotPersonality personality, const std::string& failsafes,
                                 const std::string& changes)
    : personality_(personality) {
  // Stock values of PX4 1.15 and ArduCopter 4.5, as far as something here obeys them.
  if (personality == AutopilotPersonality::kPx4) {
    parameters_ = {{"NAV_DLL_ACT", 0, true},         {"NAV_RCL_ACT", 2, true},
                   {"COM_DL_LOSS_T", 10, true},      {"COM_LOW_BAT_ACT", 0, true},
                   {"BAT_LOW_THR", 0.15, false},     {"BAT_CRIT_THR", 0.07, false},
                   {"BAT_EMERGEN_THR", 0.05, false}, {"GF_ACTION", 2, true},
                   {"GF_MAX_HOR_DIST", 0, false},    {"GF_MAX_VER_DIST", 0, false},
                   {"NAV_ACC_RAD", 10, false},       {"MPC_XY_CRUISE", 5, false},
                   {"MPC_Z_VEL_MAX_UP", 3, false},   {"MPC_Z_VEL_MAX_DN", 1.5, false},
                   {"MPC_LAND_SPEED", 0.7, false},   {"MIS_TAKEOFF_ALT", 2.5, false},
                   {"RTL_RETURN_ALT", 60, false},    {"RTL_LAND_DELAY", 0, false},
                   {"COM_DISARM_LAND", 2, false},    {"COM_DISARM_PRFLT", 10, false},
                   {"MAV_SYS_ID", 1, true},          {"SYS_AUTOSTART", 4001, true}};
  } else {
    parameters_ = {{"FS_GCS_ENABLE", 0, true},     {"FS_GCS_TIMEOUT", 4.5, false},
                   {"FENCE_ENABLE", 0, true},      {"FENCE_TYPE", 7, true},
                   {"FENCE_ACTION", 1, true},      {"FENCE_ALT_MAX", 100, false},
                   {"FENCE_RADIUS", 300, false},   {"FENCE_MARGIN", 2, false},
                   {"BATT_FS_LOW_ACT", 0, true},   {"BATT_FS_CRT_ACT", 0, true},
                   {"BATT_LOW_MAH", 0, false},     {"BATT_CRT_MAH", 0, false},
                   {"BATT_CAPACITY", 6750, true},  {"RTL_ALT", 1500, true},
                   {"RTL_LOIT_TIME", 5000, true},  {"WPNAV_SPEED", 1000, false},
                   {"WPNAV_SPEED_UP", 250, false}, {"WPNAV_SPEED_DN", 150, false},
                   {"WPNAV_RADIUS", 200, false},   {"WP_YAW_BEHAVIOR", 2, true},
                   {"LAND_SPEED", 50, true},       {"ARMING_CHECK", 1, true},
                   {"DISARM_DELAY", 10, true},     {"FS_EKF_ACTION", 1, true},
                   {"SYSID_THISMAV", 1, true},     {"SYSID_MYGCS", 255, true},
                   {"CAM1_TYPE", 1, true},         {"MNT1_TYPE", 1, true}};
  }
  std::sort(parameters_.begin(), parameters_.end(),
            [](const Parameter& a, const Parameter& b) { return a.name < b.name; });
  if (failsafes == "safe") {
    ApplyChanges(personality == AutopilotPersonality::kPx4
                     ? "NAV_DLL_ACT=2,COM_LOW_BAT_ACT=3,GF_ACTION=2,RTL_RETURN_ALT=30"
                     : "FS_GCS_ENABLE=1,FENCE_ENABLE=1,BATT_FS_LOW_ACT=2,BATT_FS_CRT_ACT=1,"
                       "BATT_LOW_MAH=1000,BATT_CRT_MAH=450,RTL_ALT=3000");
  }
  ApplyChanges(changes);
}

void DroneParameters::ApplyChanges(const std::string& changes) {
  for (const std::string& item : SplitAtCommas(changes)) {
    const auto equals = item.find('=');
    const std::string name = item.substr(0, equals);
    std::size_t used = 0;
    double value = 0;
    try {
      if (equals != std::string::npos) value = std::stod(item.substr(equals + 1), &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || equals + 1 + used != item.size() || !std::isfinite(value)) {
      throw UsageError("Drone.parameters: '" + item + "' is not NAME=VALUE");
    }
    if (IndexOf(name) < 0) throw UsageError("Drone.parameters: no parameter " + name);
    Set(name, value);
  }
}

int DroneParameters::IndexOf(const std::string& name) const {
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    if (parameters_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

double DroneParameters::Get(const std::string& name) const {
  return parameters_.at(static_cast<std::size_t>(IndexOf(name))).value;
}

void DroneParameters::Set(const std::string& name, double value) {
  Parameter& parameter = parameters_.at(static_cast<std::size_t>(IndexOf(name)));
  parameter.value = parameter.is_integer ? std::round(value) : value;
}

// PX4 puts an integer's bits into the float, ArduPilot its value.
MavParamValue DroneParameters::ValueMessage(std::size_t index) const {
  const Parameter& parameter = parameters_[index];
  MavParamValue message;
  SetMavText(parameter.name, &message.param_id);
  message.param_type = parameter.is_integer ? MavParamType::kInt32 : MavParamType::kReal32;
  message.param_count = static_cast<std::uint16_t>(parameters_.size());
  message.param_index = static_cast<std::uint16_t>(index);
  message.param_value = static_cast<float>(parameter.value);
  if (parameter.is_integer && personality_ == AutopilotPersonality::kPx4) {
    message.param_value = std::bit_cast<float>(static_cast<std::int32_t>(parameter.value));
  }
  return message;
}

void DroneParameters::Answer(const MavParamRequestRead& request, const Send& send) const {
  const int index =
      request.param_index >= 0 ? request.param_index : IndexOf(MavText(request.param_id));
  if (index < 0 || index >= static_cast<int>(parameters_.size())) return;  // both stacks are silent
  send(ValueMessage(static_cast<std::size_t>(index)));
}

void DroneParameters::Answer(const MavParamSet& request, const Send& send) {
  const int index = IndexOf(MavText(request.param_id));
  if (index < 0) return;
  Parameter& parameter = parameters_[static_cast<std::size_t>(index)];
  double value = static_cast<double>(request.param_value);
  if (parameter.is_integer && personality_ == AutopilotPersonality::kPx4) {
    value = std::bit_cast<std::int32_t>(request.param_value);
  }
  const bool is_typed = personality_ == AutopilotPersonality::kArduPilot ||
                        (request.param_type == MavParamType::kReal32) != parameter.is_integer;
  if (is_typed && std::isfinite(value)) Set(parameter.name, value);
  send(ValueMessage(static_cast<std::size_t>(index)));
}

void DroneParameters::StepList(const Send& send) {
  if (next_in_list_ >= parameters_.size()) return;
  send(ValueMessage(next_in_list_++));
}

}  // namespace colmap_ext
