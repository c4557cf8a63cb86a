#include "flight/picture_store.h"

#include <fcntl.h>
#include <openssl/sha.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

bool LooksLikePicture(const std::string& bytes) {
  const bool is_jpeg = bytes.starts_with("\xFF\xD8\xFF");
  const bool is_png = bytes.starts_with("\x89PNG");
  const bool is_tiff =
      bytes.starts_with(std::string("II*\0", 4)) || bytes.starts_with(std::string("MM\0*", 4));
  // A JPEG that was cut on its way lacks its end mark.
  const bool is_whole =
      !is_jpeg || bytes.find("\xFF\xD9", bytes.size() - std::min<std::size_t>(bytes.size(), 64)) !=
                      std::string::npos;
  return (is_jpeg || is_png || is_tiff) && is_whole;
}

void AppendLine(const std::filesystem::path& path, const std::string& line) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0) throw Error(path.string() + ": cannot be opened");
  const ssize_t written = write(descriptor, line.data(), line.size());
  const bool is_good = written == static_cast<ssize_t>(line.size()) && fdatasync(descriptor) == 0;
  close(descriptor);
  if (!is_good) throw Error(path.string() + ": cannot be written");
}

}  // namespace

std::string Sha256Hex(const std::string& bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  std::string text;
  for (const unsigned char byte : digest) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

std::string StorePicture(const Workspace& workspace, const FetchRequest& request,
                         const FlightMission& mission, const std::string& bytes) {
  if (!LooksLikePicture(bytes)) {
    throw Error(request.photo + ": what the camera sent is no whole picture (" +
                std::to_string(bytes.size()) + " bytes)");
  }
  const std::filesystem::path folder =
      request.full_resolution ? workspace.images_full() : workspace.images();
  RequireWritableFolder(folder, "photos");
  if (!request.full_resolution) {
    CaptureRecord record = request.capture.record;
    record.position.height_m += mission.undulation_m;
    AppendLine(folder / "captures.jsonl", CaptureJournalLine(request.photo, record));
  }
  WriteFileAtomically(folder / request.photo, bytes);
  return Sha256Hex(bytes);
}

}  // namespace colmap_ext
