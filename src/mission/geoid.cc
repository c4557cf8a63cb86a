#include "colmap_ext/mission/geoid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// GTX numbers are big-endian.
template <typename Bits>
Bits BigEndian(const std::string& bytes, std::size_t at) {
  Bits bits = 0;
  for (std::size_t i = 0; i < sizeof(Bits); ++i) {
    bits = static_cast<Bits>((bits << 8) | static_cast<unsigned char>(bytes[at + i]));
  }
  return bits;
}

double DoubleAt(const std::string& bytes, std::size_t at) {
  return std::bit_cast<double>(BigEndian<std::uint64_t>(bytes, at));
}

// Rows from south to north, columns from west to east.
struct GtxGrid {
  const std::string& bytes;
  double south_deg = 0, west_deg = 0, step_lat_deg = 0, step_lon_deg = 0;
  std::uint32_t rows = 0, cols = 0;

  double At(std::uint32_t row, std::uint32_t col) const {
    constexpr std::size_t kHeader = 40;
    const std::size_t index = std::size_t{row} * cols + col % cols;
    return static_cast<double>(
        std::bit_cast<float>(BigEndian<std::uint32_t>(bytes, kHeader + 4 * index)));
  }
};

GtxGrid ReadHeader(const std::string& bytes, const std::filesystem::path& path) {
  const auto require = [&](bool is_right) {
    if (!is_right) throw Error(path.string() + ": not a GTX grid of the whole Earth");
  };
  require(bytes.size() > 40);
  const GtxGrid grid{bytes,
                     DoubleAt(bytes, 0),
                     DoubleAt(bytes, 8),
                     DoubleAt(bytes, 16),
                     DoubleAt(bytes, 24),
                     BigEndian<std::uint32_t>(bytes, 32),
                     BigEndian<std::uint32_t>(bytes, 36)};
  require(grid.rows > 1 && grid.cols > 1 && grid.rows < 100000 && grid.cols < 100000);
  require(bytes.size() == 40 + std::size_t{4} * grid.rows * grid.cols);
  require(std::abs(grid.south_deg + 90) < 1e-6 &&
          std::abs(grid.step_lat_deg * (grid.rows - 1) - 180) < 1e-6 &&
          std::abs(grid.step_lon_deg * grid.cols - 360) < 1e-6);
  return grid;
}

}  // namespace

std::optional<double> GeoidUndulation(double lat_deg, double lon_deg,
                                      const std::filesystem::path& grid_path) {
  if (!std::filesystem::exists(grid_path)) return std::nullopt;
  const std::string bytes = ReadFile(grid_path);
  const GtxGrid grid = ReadHeader(bytes, grid_path);
  const double row = std::clamp((lat_deg - grid.south_deg) / grid.step_lat_deg, 0.0,
                                static_cast<double>(grid.rows - 1));
  double east_deg = std::fmod(lon_deg - grid.west_deg, 360.0);
  if (east_deg < 0) east_deg += 360;
  const double col = east_deg / grid.step_lon_deg;
  const auto row0 = std::min(static_cast<std::uint32_t>(row), grid.rows - 2);
  const auto col0 = static_cast<std::uint32_t>(col);
  const double v = row - row0, u = col - col0;
  const double south = (1 - u) * grid.At(row0, col0) + u * grid.At(row0, col0 + 1);
  const double north = (1 - u) * grid.At(row0 + 1, col0) + u * grid.At(row0 + 1, col0 + 1);
  return (1 - v) * south + v * north;
}

}  // namespace colmap_ext
