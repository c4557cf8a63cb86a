#include "colmap_ext/scene/las.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// Byte offsets of the public header block (LAS 1.4 specification, R15, table 3).
constexpr std::size_t kVersionMinor = 25;
constexpr std::size_t kPointDataOffset = 96;
constexpr std::size_t kPointFormat = 104;
constexpr std::size_t kRecordLength = 105;
constexpr std::size_t kLegacyPointCount = 107;
constexpr std::size_t kScale = 131;
constexpr std::size_t kOffset = 155;
constexpr std::size_t kPointCount14 = 247;
constexpr std::size_t kMinHeader = 227;     // LAS 1.0 to 1.2
constexpr std::size_t kHeader14 = 375;      // LAS 1.4
constexpr std::size_t kPositionBytes = 12;  // X, Y, Z as int32 open every record

// LAS is little-endian, like every machine that we build for.
template <typename T>
T ReadAt(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::uint64_t PointCount(const std::string& bytes) {
  const auto legacy = ReadAt<std::uint32_t>(bytes, kLegacyPointCount);
  const bool is_14 = static_cast<std::uint8_t>(bytes[kVersionMinor]) >= 4;
  if (legacy != 0 || !is_14 || bytes.size() < kHeader14) return legacy;
  return ReadAt<std::uint64_t>(bytes, kPointCount14);
}

}  // namespace

std::vector<Eigen::Vector3d> ReadLasPoints(const std::filesystem::path& path) {
  const std::string bytes = ReadFile(path);
  const auto fail = [&](const std::string& what) { throw Error(path.string() + ": " + what); };
  if (bytes.size() < kMinHeader || bytes.compare(0, 4, "LASF") != 0) fail("not a LAS file");
  // LAZ writers set the highest bits of the point format.
  if (static_cast<std::uint8_t>(bytes[kPointFormat]) >= 64) {
    fail("compressed LAS (LAZ); decompress it first, for example with `laszip` or PDAL");
  }
  const std::size_t start = ReadAt<std::uint32_t>(bytes, kPointDataOffset);
  const std::size_t record = ReadAt<std::uint16_t>(bytes, kRecordLength);
  const std::uint64_t count = PointCount(bytes);
  if (record < kPositionBytes)
    fail("records of " + std::to_string(record) + " bytes hold no point");
  if (start > bytes.size() || count > (bytes.size() - start) / record) {
    fail("truncated: its header promises " + std::to_string(count) + " points");
  }
  const auto scale = ReadAt<std::array<double, 3>>(bytes, kScale);
  const auto offset = ReadAt<std::array<double, 3>>(bytes, kOffset);
  std::vector<Eigen::Vector3d> points(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto raw = ReadAt<std::array<std::int32_t, 3>>(bytes, start + i * record);
    for (std::size_t k = 0; k < 3; ++k) {
      points[i][static_cast<Eigen::Index>(k)] = scale[k] * raw[k] + offset[k];
    }
    if (!points[i].allFinite()) fail("point " + std::to_string(i) + " is not finite");
  }
  return points;
}

}  // namespace colmap_ext
