#include "session/seen_inputs.h"

#include <chrono>
#include <sstream>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr int kSeenVersion = 1;

FileStamp StampOf(const fs::path& path) {
  std::error_code error;
  FileStamp stamp;
  const auto bytes = fs::file_size(path, error);
  if (error) return stamp;
  stamp.bytes = bytes;
  const auto time = std::chrono::file_clock::to_sys(fs::last_write_time(path, error));
  stamp.modified_us =
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
  return stamp;
}

std::map<std::string, std::string> OptionsOf(const std::string& ini_text) {
  std::map<std::string, std::string> options;
  std::istringstream lines(ini_text);
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1) + ".";
    const std::size_t equals = line.find(" = ");
    if (equals == std::string::npos) continue;
    options[section + line.substr(0, equals)] = line.substr(equals + 3);
  }
  return options;
}

// "a.jpg, b.jpg, c.jpg and 4 more"
std::string Named(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

std::string Photos(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " photo" : " photos");
}

Json ToJson(const FileStamp& stamp) { return Json::array({stamp.bytes, stamp.modified_us}); }

FileStamp StampFrom(const JsonNode& node) {
  const std::vector<JsonNode> items = node.Items();
  if (items.size() != 2) node.Fail("must be [bytes, microseconds]");
  return {static_cast<std::uint64_t>(items[0].Number()),
          static_cast<std::int64_t>(items[1].Number())};
}

}  // namespace

SeenInputs LookAtInputs(const fs::path& image_path, const fs::path& database_path,
                        const std::string& ini_text) {
  SeenInputs seen;
  if (fs::is_directory(image_path)) {
    for (const std::string& name : ListPhotos(image_path)) {
      seen.photos[name] = StampOf(image_path / name);
    }
  }
  seen.database = StampOf(database_path);
  seen.options = OptionsOf(ini_text);
  return seen;
}

void WriteSeenInputs(const SeenInputs& seen, const fs::path& path) {
  Json photos = Json::object();
  for (const auto& [name, stamp] : seen.photos) photos[name] = ToJson(stamp);
  WriteJsonFile({{"version", kSeenVersion},
                 {"database", ToJson(seen.database)},
                 {"options", seen.options},
                 {"photos", photos}},
                path);
}

InputChanges CompareInputs(const SeenInputs& before, const SeenInputs& now,
                           const fs::path& image_path, const fs::path& database_path,
                           bool database_is_ours) {
  InputChanges changes;
  std::vector<std::string> removed, replaced;
  for (const auto& [name, stamp] : before.photos) {
    const auto found = now.photos.find(name);
    if (found == now.photos.end()) {
      removed.push_back(name);
    } else if (found->second != stamp) {
      replaced.push_back(name);
    }
  }
  if (!removed.empty()) {
    changes.warnings.push_back(Photos(removed.size()) + " of this session are no longer in " +
                               image_path.string() + ": " + Named(removed) +
                               "; put them back, or start a new workspace");
  }
  changes.removed_photos = removed;
  if (!replaced.empty()) {
    changes.warnings.push_back(Photos(replaced.size()) + " in " + image_path.string() +
                               " changed since the session used them: " + Named(replaced) +
                               "; put the old ones back, or give new ones new names");
  }
  if (!database_is_ours && before.database != FileStamp() && now.database != before.database) {
    changes.warnings.push_back(
        database_path.string() +
        (now.database == FileStamp()
             ? ": the database is gone; put it back, or start a new workspace"
             : ": another program changed the database since the last iteration"));
  }
  for (const auto& [name, value] : now.options) {
    const auto found = before.options.find(name);
    if (found == before.options.end() || found->second == value) continue;
    changes.notes.push_back("option changed since the last iteration: " + name + ": " +
                            found->second + " before, " + value + " now");
  }
  return changes;
}

SeenInputs ReadSeenInputs(const fs::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  if (root["version"].Integer() != kSeenVersion) {
    root["version"].Fail("is not a version that this program knows; use a new workspace");
  }
  SeenInputs seen;
  seen.database = StampFrom(root["database"]);
  const JsonNode photos = root["photos"], options = root["options"];
  for (const auto& [name, value] : json["photos"].items())
    seen.photos[name] = StampFrom(photos[name]);
  for (const auto& [name, value] : json["options"].items()) {
    seen.options[name] = options[name].Text();
  }
  return seen;
}

}  // namespace colmap_ext
