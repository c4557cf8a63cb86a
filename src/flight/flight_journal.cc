#include "colmap_ext/flight/flight_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

[[noreturn]] void FailWith(const std::filesystem::path& path, const char* what) {
  throw Error(path.string() + ": " + what + ": " + std::strerror(errno));
}

void WriteAll(int descriptor, const std::string& text, const std::filesystem::path& path) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) FailWith(path, "the flight journal cannot be written");
    written += static_cast<std::size_t>(count);
  }
}

// A new file's name is only safe when its folder is, too.
void SyncFolder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

FlightLedger ReplayJournal(const std::string& text, const std::string& name,
                           std::size_t* whole_bytes) {
  FlightLedger ledger;
  std::size_t begin = 0;
  for (int number = 1;; ++number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;
    const std::string where = name + ": line " + std::to_string(number);
    const Json json = Json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin),
                                  text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    if (json.is_discarded() || !json.is_object()) throw Error(where + ": not a JSON object");
    ApplyRecord(JsonNode(json, where), &ledger);
    begin = end + 1;
  }
  if (whole_bytes != nullptr) *whole_bytes = begin;
  return ledger;
}

FlightJournal::FlightJournal(const std::filesystem::path& path) : path_(path) {
  RequireWritableFolder(path.parent_path(), "flight journal");
  std::size_t whole_bytes = 0;
  if (std::filesystem::exists(path)) {
    ledger_ = ReplayJournal(ReadFile(path), path.string(), &whole_bytes);
  }
  descriptor_ = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) FailWith(path, "the flight journal cannot be opened");
  if (ftruncate(descriptor_, static_cast<off_t>(whole_bytes)) != 0 ||
      lseek(descriptor_, 0, SEEK_END) < 0 || fsync(descriptor_) != 0) {
    close(descriptor_);
    FailWith(path, "the flight journal cannot be continued");
  }
  SyncFolder(path.parent_path());
}

FlightJournal::~FlightJournal() { close(descriptor_); }

void FlightJournal::Append(const std::vector<Json>& records) {
  std::string text;
  for (const Json& record : records) {
    text += record.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  }
  WriteAll(descriptor_, text, path_);
  if (fdatasync(descriptor_) != 0) FailWith(path_, "the flight journal cannot be written to disk");
}

}  // namespace colmap_ext
