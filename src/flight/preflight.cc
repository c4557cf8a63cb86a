#include "colmap_ext/flight/preflight.h"

#include <cmath>
#include <cstdio>

#include "colmap_ext/flight/segment_checks.h"

namespace colmap_ext {
namespace {

// One parameter of the vehicle whose value decides whether a failsafe is on.
struct Failsafe {
  const char* parameter;
  const char* name;
  bool (*is_on)(double value);
  const char* advice;
};

bool IsAboveZero(double value) { return value > 0; }
// PX4's COM_LOW_BAT_ACT: 0 warning, 2 land, 3 return at critical, land at emergency.
bool IsAtLeastTwo(double value) { return value >= 2; }
// PX4's NAV_DLL_ACT: 1 hold, 2 return, 3 land, 5 terminate, 6 lockdown.
bool IsReturnOrLand(double value) { return value == 2 || value == 3; }

constexpr Failsafe kPx4[] = {
    {"NAV_DLL_ACT", "loss of the data link", IsReturnOrLand, "set NAV_DLL_ACT to 2 (return)"},
    {"COM_LOW_BAT_ACT", "low battery", IsAtLeastTwo, "set COM_LOW_BAT_ACT to 3"},
    {"GF_ACTION", "fence", IsAtLeastTwo, "set GF_ACTION to 2 (hold) or 3 (return)"},
};
constexpr Failsafe kArduPilot[] = {
    {"FS_GCS_ENABLE", "loss of the data link", IsAboveZero, "set FS_GCS_ENABLE to 1 (return)"},
    {"BATT_FS_LOW_ACT", "low battery", IsAboveZero, "set BATT_FS_LOW_ACT to 2 (return)"},
    {"FENCE_ENABLE", "fence", IsAboveZero, "set FENCE_ENABLE to 1"},
};

template <typename Visit>
void ForEachFailsafe(AutopilotStack stack, const Visit& visit) {
  if (stack == AutopilotStack::kPx4) {
    for (const Failsafe& failsafe : kPx4) visit(failsafe);
  } else if (stack == AutopilotStack::kArduPilot) {
    for (const Failsafe& failsafe : kArduPilot) visit(failsafe);
  }
}

std::string Format(const char* format, double a, double b) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

void CheckFailsafes(const VehicleState& vehicle, const PreflightFacts& facts,
                    std::vector<PreflightItem>* items) {
  ForEachFailsafe(vehicle.stack, [&](const Failsafe& failsafe) {
    PreflightItem item{std::string("failsafe: ") + failsafe.name, true, true, ""};
    const auto value = facts.parameters.find(failsafe.parameter);
    if (value == facts.parameters.end()) {
      item.is_good = false;
      item.text = std::string(failsafe.parameter) + " did not answer";
    } else {
      item.is_good = failsafe.is_on(value->second);
      item.text = std::string(failsafe.parameter) + Format(" is %g", value->second, 0);
      if (!item.is_good) item.text += std::string(": off; ") + failsafe.advice;
    }
    items->push_back(item);
  });
}

// Height above home at which the autopilot returns; NaN: unknown.
double ReturnHeight(AutopilotStack stack, const PreflightFacts& facts) {
  const auto find = [&](const char* name, double factor) {
    const auto value = facts.parameters.find(name);
    return value == facts.parameters.end() ? std::nan("") : value->second * factor;
  };
  if (stack == AutopilotStack::kPx4) return find("RTL_RETURN_ALT", 1);
  const double metres = find("RTL_ALT_M", 1);
  return std::isnan(metres) ? find("RTL_ALT", 0.01) : metres;
}

PreflightItem CheckReturnHeight(const VehicleState& vehicle, const PreflightFacts& facts,
                                double highest_m) {
  const double height_m = ReturnHeight(vehicle.stack, facts);
  if (std::isnan(height_m)) {
    return {"return height", false, true, "the vehicle does not say how high it returns"};
  }
  const bool is_good = height_m >= highest_m + 2;
  return {"return height", is_good, true,
          Format("%.0f m above home; what is known is %.0f m high", height_m, highest_m) +
              (is_good ? "" : ": raise RTL_RETURN_ALT (PX4) or RTL_ALT (ArduPilot)")};
}

PreflightItem CheckBattery(const VehicleState& vehicle, const FlightOptions& options) {
  if (!vehicle.battery_percent) {
    return {"battery", false, false, "the vehicle does not report its battery"};
  }
  return {
      "battery", *vehicle.battery_percent >= options.min_battery_percent, false,
      Format("%.0f %% (least: %.0f %%)", *vehicle.battery_percent, options.min_battery_percent)};
}

PreflightItem CheckGps(const VehicleState& vehicle, const FlightOptions& options) {
  const bool has_fix = vehicle.gps_fix >= 3;
  const double sigma_m = vehicle.sigma_horizontal_m.value_or(0);
  return {"position", has_fix && sigma_m <= options.max_sigma_m, false,
          has_fix ? Format("fix, %.1f m accurate (needed: %.1f m)", sigma_m, options.max_sigma_m)
                  : "no three-dimensional fix"};
}

PreflightItem CheckHome(const VehicleState& vehicle, const FlightMission& mission,
                        const FlightOptions& options) {
  if (!vehicle.home) return {"home", false, false, "the vehicle has no home position"};
  const Eigen::Vector3d home = mission.WorldFromAmsl(*vehicle.home);
  const double distance_m = home.head<2>().norm();
  if (distance_m > 5000) {
    return {
        "home", false, false,
        Format("%.0f m from the mission's origin: the mission of another site?", distance_m, 0)};
  }
  if (!mission.limits.fence.empty() && !IsInsidePolygon(mission.limits.fence, home.head<2>())) {
    return {"home", false, false, "the vehicle stands outside of the mission's fence"};
  }
  if (!mission.home_z_m) return {"home", true, false, "known (the mission plans no height of it)"};
  const double error_m = home.z() - *mission.home_z_m;
  return {"home", std::abs(error_m) <= options.max_home_error_m, false,
          Format("%.1f m above where the mission has it (at most %.1f m off)", error_m,
                 options.max_home_error_m)};
}

}  // namespace

std::vector<std::string> PreflightParameters(AutopilotStack stack) {
  std::vector<std::string> names;
  ForEachFailsafe(stack, [&](const Failsafe& failsafe) { names.emplace_back(failsafe.parameter); });
  if (stack == AutopilotStack::kPx4) names.emplace_back("RTL_RETURN_ALT");
  if (stack == AutopilotStack::kArduPilot) names.emplace_back("RTL_ALT");
  return names;
}

std::vector<PreflightItem> CheckPreflight(const VehicleState& vehicle, const PreflightFacts& facts,
                                          const FlightMission& mission, double highest_m,
                                          const FlightOptions& options) {
  std::vector<PreflightItem> items;
  items.push_back({"vehicle", vehicle.stack != AutopilotStack::kUnknown, false,
                   vehicle.stack != AutopilotStack::kUnknown
                       ? vehicle.description
                       : "neither PX4 nor ArduPilot: it is not known how to fly it"});
  items.push_back(CheckGps(vehicle, options));
  items.push_back({"estimator", vehicle.is_estimate_good.value_or(false), false,
                   vehicle.is_estimate_good ? (*vehicle.is_estimate_good ? "good" : "not ready")
                                            : "the vehicle does not report it"});
  items.push_back(CheckHome(vehicle, mission, options));
  items.push_back(CheckBattery(vehicle, options));
  items.push_back({"camera", true, false,
                   facts.has_camera ? "answers" : "nobody answers; DIGICAM_CONTROL will be tried"});
  items.push_back({"gimbal", true, false,
                   facts.has_gimbal ? "answers" : "nobody answers; MOUNT_CONTROL will be tried"});
  if (!mission.limits.fence.empty()) {
    const bool is_good = facts.fence_uploaded || !options.upload_fence;
    items.push_back({"fence in the vehicle", is_good, true,
                     facts.fence_uploaded    ? "written and read back"
                     : !options.upload_fence ? "not written (--Flight.upload_fence 0)"
                                             : facts.fence_problem});
  }
  CheckFailsafes(vehicle, facts, &items);
  items.push_back(CheckReturnHeight(vehicle, facts, highest_m));
  return items;
}

std::vector<PreflightItem> Blocking(const std::vector<PreflightItem>& items,
                                    const FlightOptions& options) {
  std::vector<PreflightItem> blocking;
  for (const PreflightItem& item : items) {
    if (item.is_good || (item.is_failsafe && options.allow_disabled_failsafes)) continue;
    blocking.push_back(item);
  }
  return blocking;
}

}  // namespace colmap_ext
