#include "colmap_ext/scene/dense_map.h"

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/byte_reader.h"

namespace colmap_ext {
namespace {

constexpr int kMaxSide = 65536;
constexpr int kMaxChannels = 16;

// A number of the header up to its '&'.
int ReadHeaderNumber(ByteReader& in, const char* what, int max_value) {
  std::string digits;
  for (char c = in.Read<char>(what); c != '&'; c = in.Read<char>(what)) {
    digits += c;
    if (c < '0' || c > '9' || digits.size() > 6) {
      in.Fail("no number for " + std::string(what) +
              "; a depth or normal map begins with width&height&channels&");
    }
  }
  int value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (value < 1 || value > max_value) {
    in.Fail(std::string(what) + " is " + (digits.empty() ? "missing" : digits) + ", not 1 to " +
            std::to_string(max_value) + "; the file is no depth or normal map, or corrupt");
  }
  return value;
}

std::size_t NumValues(int width, int height, int channels) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(channels);
}

}  // namespace

DenseMap::DenseMap(int width, int height, int channels)
    : width(width),
      height(height),
      channels(channels),
      data(NumValues(width, height, channels), 0.0f) {}

DenseMap ReadDenseMap(const std::filesystem::path& path) {
  ByteReader in(path);
  const int width = ReadHeaderNumber(in, "the width", kMaxSide);
  const int height = ReadHeaderNumber(in, "the height", kMaxSide);
  const int channels = ReadHeaderNumber(in, "the number of channels", kMaxChannels);
  // Compared before the map is allocated: a corrupt header must not cost gigabytes.
  const std::size_t num_bytes = NumValues(width, height, channels) * sizeof(float);
  if (in.remaining() != num_bytes) {
    in.Fail("a map of " + std::to_string(width) + " x " + std::to_string(height) + " x " +
            std::to_string(channels) + " has " + std::to_string(num_bytes) +
            " bytes after its header, the file has " + std::to_string(in.remaining()) +
            "; it is truncated or corrupt, write it again");
  }
  DenseMap map(width, height, channels);
  in.Take(map.data.data(), num_bytes, "the map");
  return map;
}

void WriteDenseMap(const DenseMap& map, const std::filesystem::path& path) {
  const bool is_sane = map.width >= 1 && map.width <= kMaxSide && map.height >= 1 &&
                       map.height <= kMaxSide && map.channels >= 1 && map.channels <= kMaxChannels;
  if (!is_sane || map.data.size() != NumValues(map.width, map.height, map.channels)) {
    throw Error(path.string() + ": a map of " + std::to_string(map.width) + " x " +
                std::to_string(map.height) + " x " + std::to_string(map.channels) + " with " +
                std::to_string(map.data.size()) + " values cannot be written");
  }
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << map.width << '&' << map.height << '&' << map.channels << '&';
    out.write(reinterpret_cast<const char*>(map.data.data()),
              static_cast<std::streamsize>(map.data.size() * sizeof(float)));
  });
}

}  // namespace colmap_ext
