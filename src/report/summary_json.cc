#include "colmap_ext/report/summary_json.h"

#include <algorithm>
#include <cstdlib>

#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {
namespace {

Json IterationToJson(const IterationSummary& iteration) {
  Json json = {{"photos", iteration.photos}, {"registered", iteration.registered}};
  if (iteration.covered_ratio) json["covered_ratio"] = *iteration.covered_ratio;
  if (iteration.reachable_covered_ratio) {
    json["reachable_covered_ratio"] = *iteration.reachable_covered_ratio;
  }
  json["planned_views"] = iteration.planned_views;
  if (iteration.mean_error_m) json["mean_error_m"] = *iteration.mean_error_m;
  if (iteration.rms_error_m) json["rms_error_m"] = *iteration.rms_error_m;
  for (const CompletenessValue& value : iteration.completeness) {
    json["completeness"][value.key] = value.share;
  }
  json["wall_s"] = iteration.wall_s;
  if (!iteration.stage_wall_s.empty()) json["stage_wall_s"] = iteration.stage_wall_s;
  if (!iteration.unregistered.empty()) json["unregistered"] = iteration.unregistered;
  return json;
}

std::optional<double> OptionalNumber(const JsonNode& node, const std::string& key) {
  const auto found = node.Find(key);
  return found ? std::optional<double>(found->Number()) : std::nullopt;
}

// JsonNode walks objects by known keys; these have free ones, so their names come from `json`.
IterationSummary IterationFromJson(const JsonNode& node, const Json& json) {
  IterationSummary iteration;
  iteration.photos = node["photos"].Integer();
  iteration.registered = node["registered"].Integer();
  iteration.covered_ratio = OptionalNumber(node, "covered_ratio");
  iteration.reachable_covered_ratio = OptionalNumber(node, "reachable_covered_ratio");
  if (const auto planned = node.Find("planned_views")) iteration.planned_views = planned->Integer();
  iteration.mean_error_m = OptionalNumber(node, "mean_error_m");
  iteration.rms_error_m = OptionalNumber(node, "rms_error_m");
  iteration.wall_s = node["wall_s"].Number();
  if (const auto completeness = node.Find("completeness")) {
    for (const auto& [key, value] : json.at("completeness").items()) {
      iteration.completeness.push_back({key, (*completeness)[key].Number()});
    }
  }
  if (const auto stages = node.Find("stage_wall_s")) {
    for (const auto& [key, value] : json.at("stage_wall_s").items()) {
      iteration.stage_wall_s[key] = (*stages)[key].Number();
    }
  }
  if (const auto names = node.Find("unregistered")) {
    for (const JsonNode& name : names->Items()) iteration.unregistered.push_back(name.Text());
  }
  return iteration;
}

}  // namespace

Json SummaryToJson(const SessionSummary& summary) {
  Json json = {{"finished", summary.finished}, {"iterations", Json::array()}};
  for (const IterationSummary& iteration : summary.iterations) {
    json["iterations"].push_back(IterationToJson(iteration));
  }
  return json;
}

void WriteSummary(const SessionSummary& summary, const std::filesystem::path& path) {
  WriteJsonFile(SummaryToJson(summary), path);
}

SessionSummary ReadSummary(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  SessionSummary summary;
  summary.finished = root["finished"].Text();
  std::size_t index = 0;
  for (const JsonNode& node : root["iterations"].Items()) {
    summary.iterations.push_back(IterationFromJson(node, json.at("iterations").at(index++)));
  }
  return summary;
}

std::map<std::string, double> ReadStageSeconds(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  if (!json.is_object()) root.Fail("expected an object of stages");
  std::map<std::string, double> seconds;
  for (const auto& [stage, cost] : json.items()) seconds[stage] = root[stage]["wall_s"].Number();
  return seconds;
}

}  // namespace colmap_ext
