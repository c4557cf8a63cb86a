#include "colmap_ext/sim/drone_faults.h"

#include <cmath>
#include <functional>
#include <map>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

double NumberOf(const std::string& key, const Json& value, double low, double high) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= low && number <= high)) {
    throw UsageError("fault '" + key + "' must be a number in [" + Json(low).dump() + ", " +
                     Json(high).dump() + "]");
  }
  return number;
}

bool FlagOf(const std::string& key, const Json& value) {
  if (!value.is_boolean()) throw UsageError("fault '" + key + "' must be true or false");
  return value.get<bool>();
}

CameraFault CameraFaultOf(const Json& value) {
  if (value == false) return CameraFault::kNone;
  if (value == true) return CameraFault::kRefuses;
  if (value == "report") return CameraFault::kReports;
  if (value == "silent") return CameraFault::kSilent;
  throw UsageError("fault 'camera_failed' must be true, false, \"report\" or \"silent\"");
}

using Change = std::function<void(const std::string& key, const Json& value)>;

std::map<std::string, Change> ChangesOf(DroneFaults* f, DroneEvents* e) {
  const auto number = [](double* target, double low, double high) {
    return [=](const std::string& key, const Json& value) {
      *target = NumberOf(key, value, low, high);
    };
  };
  const auto flag = [](bool* target) {
    return [=](const std::string& key, const Json& value) { *target = FlagOf(key, value); };
  };
  return {{"loss", number(&f->link.loss, 0, 1)},
          {"duplication", number(&f->link.duplication, 0, 1)},
          {"corruption", number(&f->link.corruption, 0, 1)},
          {"delay_s", number(&f->link.delay_s, 0, 60)},
          {"jitter_s", number(&f->link.jitter_s, 0, 60)},
          {"link_lost", flag(&f->link.is_cut)},
          {"gps_glitch_m", number(&f->gps_glitch_m, -1000, 1000)},
          {"gps_lost", flag(&f->gps_lost)},
          {"gimbal_stuck", flag(&f->gimbal_stuck)},
          {"wind_m_s", number(&f->wind.mean_m_s, 0, 20)},
          {"wind_from_deg", number(&f->wind.from_deg, -360, 360)},
          {"gust_m_s", number(&f->wind.gust_m_s, 0, 10)},
          {"crash", flag(&e->crash)},
          {"camera_failed",
           [f](const std::string&, const Json& value) { f->camera = CameraFaultOf(value); }},
          {"battery_percent",
           [e](const std::string& key, const Json& value) {
             e->battery_percent = NumberOf(key, value, 0, 100);
           }},
          {"pilot_mode", [e](const std::string& key, const Json& value) {
             if (!value.is_string()) throw UsageError("fault '" + key + "' must be a mode's name");
             e->pilot_mode = value.get<std::string>();
           }}};
}

}  // namespace

DroneEvents ChangeFaults(const std::string& json_text, DroneFaults* faults) {
  const Json json = Json::parse(json_text, nullptr, false);
  if (!json.is_object()) throw UsageError("faults must be a JSON object");
  DroneFaults changed = *faults;
  DroneEvents events;
  const std::map<std::string, Change> changes = ChangesOf(&changed, &events);
  for (const auto& [key, value] : json.items()) {
    const auto change = changes.find(key);
    if (change == changes.end()) throw UsageError("no fault '" + key + "'");
    change->second(key, value);
  }
  *faults = changed;
  return events;
}

Json ToJson(const DroneFaults& faults) {
  Json camera = faults.camera == CameraFault::kRefuses;
  if (faults.camera == CameraFault::kReports) camera = "report";
  if (faults.camera == CameraFault::kSilent) camera = "silent";
  return {{"loss", faults.link.loss},
          {"duplication", faults.link.duplication},
          {"corruption", faults.link.corruption},
          {"delay_s", faults.link.delay_s},
          {"jitter_s", faults.link.jitter_s},
          {"link_lost", faults.link.is_cut},
          {"gps_glitch_m", faults.gps_glitch_m},
          {"gps_lost", faults.gps_lost},
          {"camera_failed", camera},
          {"gimbal_stuck", faults.gimbal_stuck},
          {"wind_m_s", faults.wind.mean_m_s},
          {"wind_from_deg", faults.wind.from_deg},
          {"gust_m_s", faults.wind.gust_m_s}};
}

void Apply(const DroneFaults& faults, SimulatedAutopilot* drone) {
  drone->SetGpsGlitch(faults.gps_glitch_m);
  drone->SetGpsLost(faults.gps_lost);
  drone->SetCameraFault(faults.camera);
  drone->SetGimbalStuck(faults.gimbal_stuck);
  drone->SetWind(faults.wind);
}

}  // namespace colmap_ext
