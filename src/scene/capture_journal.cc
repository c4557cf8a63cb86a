#include "colmap_ext/scene/capture_journal.h"

#include <cmath>
#include <string_view>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// Camera forward, right, down from COLMAP's right, down, forward.
Eigen::Matrix3d ForwardRightDownFromCam() {
  Eigen::Matrix3d matrix;
  matrix << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return matrix;
}

// East, north, up from north, east, down; its own inverse.
Eigen::Matrix3d EnuFromNed() {
  Eigen::Matrix3d matrix;
  matrix << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return matrix;
}

// [w, x, y, z]; all zero: not known.
std::optional<Eigen::Quaterniond> ReadAttitude(const JsonNode& node) {
  const std::vector<JsonNode> items = node.Items();
  if (items.size() != 4) node.Fail("expected four numbers [w, x, y, z]");
  const Eigen::Quaterniond ned_from_frd(items[0].Number(), items[1].Number(), items[2].Number(),
                                        items[3].Number());
  if (ned_from_frd.norm() == 0) return std::nullopt;
  if (!(std::abs(ned_from_frd.norm() - 1) < 0.01))
    node.Fail("the quaternion is not of unit length");
  const Eigen::Matrix3d enu_from_cam =
      EnuFromNed() * ned_from_frd.normalized().toRotationMatrix() * ForwardRightDownFromCam();
  return Eigen::Quaterniond(enu_from_cam.transpose()).normalized();
}

std::optional<double> ReadSigma(const JsonNode& root, const char* key) {
  const std::optional<JsonNode> node = root.Find(key);
  if (!node) return std::nullopt;
  const double sigma = node->Number();
  if (!(sigma > 0)) node->Fail("must be above 0 m");
  return sigma;
}

CaptureRecord ReadRecord(const JsonNode& root) {
  CaptureRecord record;
  record.position = {root["lat"].Number(), root["lon"].Number(), root["height_m"].Number()};
  if (!IsValid(record.position)) root.Fail("latitude or longitude is out of range");
  if (const auto index = root.Find("index")) record.index = index->Integer();
  if (const auto time = root.Find("time")) record.time = time->Text();
  if (const auto q = root.Find("q")) record.cam_from_enu = ReadAttitude(*q);
  record.sigma_horizontal_m = ReadSigma(root, "sigma_h_m");
  record.sigma_vertical_m = ReadSigma(root, "sigma_v_m");
  return record;
}

Json ParseRecord(std::string_view line, const std::string& where) {
  Json json = Json::parse(line, nullptr, false);
  if (json.is_discarded() || !json.is_object()) throw Error(where + ": not a JSON object");
  return json;
}

void AddRecord(const Json& json, const std::string& where,
               std::map<std::string, CaptureRecord>* records) {
  const JsonNode root(json, where);
  if (root["type"].Text() != "capture") return;
  if (const auto result = root.Find("result"); result && result->Integer() == 0) return;
  const std::string file = root["file"].Text();
  if (file.empty()) root["file"].Fail("the name is empty");
  const CaptureRecord record = ReadRecord(root);
  const auto [entry, is_new] = records->emplace(file, record);
  if (is_new || (record.index >= 0 && record.index == entry->second.index)) return;
  root["file"].Fail("this picture was recorded before under another index");
}

}  // namespace

std::map<std::string, CaptureRecord> ReadCaptureJournal(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  std::map<std::string, CaptureRecord> records;
  std::size_t begin = 0;
  for (int number = 1;; ++number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) return records;  // the rest was cut
    const std::string_view line(text.data() + begin, end - begin);
    begin = end + 1;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const std::string where = path.string() + ": line " + std::to_string(number);
    AddRecord(ParseRecord(line, where), where, &records);
  }
}

std::string CaptureJournalLine(const std::string& file, const CaptureRecord& record) {
  Json json;
  json["type"] = "capture";
  if (record.index >= 0) json["index"] = record.index;
  if (!record.time.empty()) json["time"] = record.time;
  json["file"] = file;
  json["lat"] = record.position.lat_deg;
  json["lon"] = record.position.lon_deg;
  json["height_m"] = record.position.height_m;
  if (record.cam_from_enu) {
    const Eigen::Matrix3d ned_from_frd = EnuFromNed() *
                                         record.cam_from_enu->toRotationMatrix().transpose() *
                                         ForwardRightDownFromCam().transpose();
    const Eigen::Quaterniond q(ned_from_frd);
    json["q"] = {q.w(), q.x(), q.y(), q.z()};
  }
  if (record.sigma_horizontal_m) json["sigma_h_m"] = *record.sigma_horizontal_m;
  if (record.sigma_vertical_m) json["sigma_v_m"] = *record.sigma_vertical_m;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace colmap_ext
