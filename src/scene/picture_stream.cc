#include "scene/picture_stream.h"

#include <cstdint>
#include <cstring>

namespace colmap_ext {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

std::uint32_t BigEndian(std::string_view bytes, std::size_t offset, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value = (value << 8) | static_cast<unsigned char>(bytes[offset + i]);
  }
  return value;
}

// Offset of the first marker (its 0xFF) at or after `offset` inside entropy-coded data; npos when
// the data end before it. 0xFF00 is a coded 0xFF, 0xFFD0 … 0xFFD7 are restart markers.
std::size_t SkipEntropyData(std::string_view bytes, std::size_t offset) {
  while (true) {
    offset = bytes.find('\xFF', offset);
    if (offset == std::string_view::npos || offset + 1 >= bytes.size()) {
      return std::string_view::npos;
    }
    const auto code = static_cast<unsigned char>(bytes[offset + 1]);
    if (code == 0xFF) {
      offset += 1;
    } else if (code == 0 || (code >= 0xD0 && code <= 0xD7)) {
      offset += 2;
    } else {
      return offset;
    }
  }
}

// Walks from marker to marker (ITU T.81, annex B) to the end of the image.
std::string FindJpegDefect(std::string_view bytes) {
  const std::string truncated =
      "its JPEG data end before the end-of-image marker (truncated file?)";
  bool has_scan = false;
  std::size_t offset = 2;
  while (true) {
    if (offset + 2 > bytes.size()) return truncated;
    if (bytes[offset] != '\xFF') {
      return "its JPEG data are corrupt at byte " + std::to_string(offset);
    }
    const auto code = static_cast<unsigned char>(bytes[offset + 1]);
    if (code == 0xFF) {  // fill byte
      offset += 1;
    } else if (code == 0xD9) {
      return has_scan ? "" : "its JPEG data hold no picture";
    } else {
      if (offset + 4 > bytes.size()) return truncated;
      offset += 2 + BigEndian(bytes, offset + 2, 2);
      if (offset > bytes.size()) return truncated;
      if (code == 0xDA) {
        has_scan = true;
        offset = SkipEntropyData(bytes, offset);
        if (offset == std::string_view::npos) return truncated;
      }
    }
  }
}

std::string FindPngDefect(std::string_view bytes) {
  constexpr std::size_t kChunkFrame = 12;  // length, type and checksum
  std::size_t offset = kPngSignature.size();
  while (offset + kChunkFrame <= bytes.size()) {
    const std::uint32_t length = BigEndian(bytes, offset, 4);
    const std::string_view type = bytes.substr(offset + 4, 4);
    if (length > bytes.size() - offset - kChunkFrame) break;
    if (type == "IEND") return "";
    offset += kChunkFrame + length;
  }
  return "its PNG data end before the IEND chunk (truncated file?)";
}

}  // namespace

std::string FindPictureDefect(std::string_view bytes) {
  if (bytes.empty()) return "the file is empty";
  if (bytes.starts_with("\xFF\xD8")) return FindJpegDefect(bytes);
  if (bytes.starts_with(kPngSignature)) return FindPngDefect(bytes);
  using namespace std::string_view_literals;
  if (bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv)) return "";  // TIFF: see decoder
  return "it is no JPEG, PNG or TIFF picture";
}

}  // namespace colmap_ext
