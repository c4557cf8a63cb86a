// What a session has seen of things that others may change: photos, database, options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace colmap_ext {

// A file as it was. Two files are taken for the same when both agree.
struct FileStamp {
  std::uint64_t bytes = 0;
  std::int64_t modified_us = 0;  // since 1970
  bool operator==(const FileStamp&) const = default;
};

struct SeenInputs {
  std::map<std::string, FileStamp> photos;     // by name, of the folder of photos
  FileStamp database;                          // zeros: there was none
  std::map<std::string, std::string> options;  // "Session.max_photos" → "200"
};

// Photos that are there now, the database, and the options of `ini_text` (OptionSet::ToIni).
SeenInputs LookAtInputs(const std::filesystem::path& image_path,
                        const std::filesystem::path& database_path, const std::string& ini_text);

SeenInputs ReadSeenInputs(const std::filesystem::path& path);
void WriteSeenInputs(const SeenInputs& seen, const std::filesystem::path& path);

struct InputChanges {
  // Sentences that name what is no longer as the session used it: its results do not follow from
  // what is there now.
  std::vector<std::string> warnings;
  std::vector<std::string> removed_photos;  // names
  std::vector<std::string> notes;  // changed options, which count from the next iteration on
};

// `database_is_ours`: an interrupted iteration may have changed the database itself.
InputChanges CompareInputs(const SeenInputs& before, const SeenInputs& now,
                           const std::filesystem::path& image_path,
                           const std::filesystem::path& database_path, bool database_is_ours);

}  // namespace colmap_ext
