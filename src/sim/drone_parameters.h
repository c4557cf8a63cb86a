// The parameters of a simulated autopilot and MAVLink's parameter protocol.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/sim/autopilot.h"

namespace colmap_ext {

class DroneParameters {
 public:
  // Stock values of `personality`, then those that `failsafes` "safe" means, then "NAME=VALUE,…".
  // Throws UsageError for an unknown name or a bad value.
  DroneParameters(AutopilotPersonality personality, const std::string& failsafes,
                  const std::string& changes);

  double Get(const std::string& name) const;  // the name must be known
  int GetInt(const std::string& name) const { return static_cast<int>(Get(name)); }
  void Set(const std::string& name, double value);

  using Send = std::function<void(const MavParamValue&)>;
  void Answer(const MavParamRequestRead& request, const Send& send) const;
  void Answer(const MavParamSet& request, const Send& send);
  void StartList() { next_in_list_ = 0; }
  // Sends the next parameter of a list that was asked for.
  void StepList(const Send& send);

 private:
  struct Parameter {
    std::string name;
    double value = 0;
    bool is_integer = false;
  };
  int IndexOf(const std::string& name) const;  // -1: unknown
  MavParamValue ValueMessage(std::size_t index) const;
  void ApplyChanges(const std::string& changes);

  AutopilotPersonality personality_;
  std::vector<Parameter> parameters_;  // sorted by name
  std::size_t next_in_list_ = static_cast<std::size_t>(-1);
};

}  // namespace colmap_ext
