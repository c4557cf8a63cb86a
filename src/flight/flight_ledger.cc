#include "colmap_ext/flight/flight_ledger.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace colmap_ext {
namespace {

std::optional<double> OptionalNumber(const JsonNode& object, const char* key) {
  const std::optional<JsonNode> node = object.Find(key);
  if (!node) return std::nullopt;
  return node->Number();
}

Json QuaternionToJson(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

Eigen::Quaterniond QuaternionFromJson(const JsonNode& node) {
  const std::vector<JsonNode> items = node.Items();
  if (items.size() != 4) node.Fail("expected four numbers [w, x, y, z]");
  return {items[0].Number(), items[1].Number(), items[2].Number(), items[3].Number()};
}

// The camera's reports repeat, and may come before or after our own bookkeeping of the same
// picture: the first one counts.
void ApplyCapture(const JsonNode& record, FlightLedger* ledger) {
  const CaptureReport report = CaptureFromJson(record);
  const int view_id = record["view"].Integer();
  ledger->last_index = std::max(ledger->last_index, report.record.index);
  if (view_id < 0) {
    ledger->others.emplace(report.record.index, report);
    return;
  }
  ViewEntry& entry = ledger->views[view_id];
  if (entry.status == ViewStatus::kCaptured || entry.status == ViewStatus::kStored) return;
  entry.status = ViewStatus::kCaptured;
  entry.capture = report;
}

void ApplyStored(const JsonNode& record, FlightLedger* ledger) {
  ViewEntry& entry = ledger->views[record["view"].Integer()];
  if (record["resolution"].Text() == "full") {
    entry.full_stored = true;
    return;
  }
  entry.status = ViewStatus::kStored;
  entry.sha256 = record["sha256"].Text();
}

void ApplyAsk(const JsonNode& record, FlightLedger* ledger) {
  ViewEntry& entry = ledger->views[record["view"].Integer()];
  entry.photo = record["photo"].Text();
  entry.sequence = record["sequence"].Integer();
  if (entry.sequence == std::numeric_limits<int>::max()) record["sequence"].Fail("too large");
  ledger->last_index = record["after_index"].Integer();  // a camera may have begun anew
  ledger->next_sequence = std::max(ledger->next_sequence, entry.sequence + 1);
  if (entry.status == ViewStatus::kPending || entry.status == ViewStatus::kFailed) {
    entry.status = ViewStatus::kAsked;
  }
}

void ApplyFailed(const JsonNode& record, FlightLedger* ledger) {
  ViewEntry& entry = ledger->views[record["view"].Integer()];
  if (entry.status == ViewStatus::kCaptured || entry.status == ViewStatus::kStored) return;
  entry.status = ViewStatus::kFailed;
  entry.reason = record["reason"].Text();
}

// Its pictures are numbered anew, and what the one before held cannot be had any more.
void ApplyNewCamera(FlightLedger* ledger) {
  for (auto& [view_id, entry] : ledger->views) {
    if (entry.status == ViewStatus::kAsked || entry.status == ViewStatus::kCaptured) {
      entry.status = ViewStatus::kPending;
    }
    entry.sequence = 0;
    entry.capture.record.index = -1;
  }
  ledger->others.clear();
  ledger->last_index = -1;
}

}  // namespace

const char* Name(ViewStatus status) {
  constexpr std::array kNames = {"pending", "asked", "captured", "stored", "failed"};
  return kNames[static_cast<std::size_t>(status)];
}

void ApplyRecord(const JsonNode& record, FlightLedger* ledger) {
  const std::string type = record["type"].Text();
  if (type == "start") {
    ++ledger->flights;
    ledger->was_flying = true;
  } else if (type == "end") {
    ledger->was_flying = false;
  } else if (type == "ask") {
    ApplyAsk(record, ledger);
  } else if (type == "capture") {
    ApplyCapture(record, ledger);
  } else if (type == "stored") {
    ApplyStored(record, ledger);
  } else if (type == "failed") {
    ApplyFailed(record, ledger);
  } else if (type == "new_camera") {
    ApplyNewCamera(ledger);
  } else if (type == "retry") {
    ViewEntry& entry = ledger->views[record["view"].Integer()];
    if (entry.status == ViewStatus::kFailed) entry.status = ViewStatus::kPending;
  }
}

Json CaptureToJson(int view_id, const CaptureReport& report) {
  const CaptureRecord& record = report.record;
  Json json = {{"type", "capture"},
               {"view", view_id},
               {"index", record.index},
               {"time", record.time},
               {"lat", record.position.lat_deg},
               {"lon", record.position.lon_deg},
               {"amsl_m", record.position.height_m},
               {"succeeded", report.succeeded},
               {"file_url", report.file_url},
               {"gps_fix", report.gps_fix}};
  if (record.cam_from_enu) json["cam_from_enu"] = QuaternionToJson(*record.cam_from_enu);
  const std::array<std::pair<const char*, std::optional<double>>, 5> numbers = {{
      {"sigma_h_m", record.sigma_horizontal_m},
      {"sigma_v_m", record.sigma_vertical_m},
      {"relative_height_m", report.relative_height_m},
      {"ellipsoid_height_m", report.ellipsoid_height_m},
      {"body_yaw_rad", report.body_yaw_rad},
  }};
  for (const auto& [key, value] : numbers) {
    if (value && std::isfinite(*value)) json[key] = *value;
  }
  return json;
}

CaptureReport CaptureFromJson(const JsonNode& node) {
  CaptureReport report;
  CaptureRecord& record = report.record;
  record.index = node["index"].Integer();
  record.time = node["time"].Text();
  record.position = {node["lat"].Number(), node["lon"].Number(), node["amsl_m"].Number()};
  if (const auto q = node.Find("cam_from_enu")) record.cam_from_enu = QuaternionFromJson(*q);
  record.sigma_horizontal_m = OptionalNumber(node, "sigma_h_m");
  record.sigma_vertical_m = OptionalNumber(node, "sigma_v_m");
  report.succeeded = node["succeeded"].Boolean();
  report.file_url = node["file_url"].Text();
  report.gps_fix = node["gps_fix"].Integer();
  report.relative_height_m = OptionalNumber(node, "relative_height_m");
  report.ellipsoid_height_m = OptionalNumber(node, "ellipsoid_height_m");
  report.body_yaw_rad = OptionalNumber(node, "body_yaw_rad");
  return report;
}

}  // namespace colmap_ext
