#include "colmap_ext/mission/geoid.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mission/mission_world.h"

namespace colmap_ext {
namespace {

template <typename Bits>
std::string BigEndian(Bits bits) {
  std::string bytes;
  for (int shift = 8 * (static_cast<int>(sizeof(Bits)) - 1); shift >= 0; shift -= 8) {
    bytes += static_cast<char>((bits >> shift) & 0xff);
  }
  return bytes;
}

std::string Number(double value) { return BigEndian(std::bit_cast<std::uint64_t>(value)); }
std::string Number(float value) { return BigEndian(std::bit_cast<std::uint32_t>(value)); }

// A grid of 90 by 90 degrees: rows -90, 0, 90; columns -180, -90, 0, 90.
std::string Grid() {
  std::string bytes = Number(-90.0) + Number(-180.0) + Number(90.0) + Number(90.0);
  bytes += BigEndian(std::uint32_t{3}) + BigEndian(std::uint32_t{4});
  for (int i = 0; i < 12; ++i) bytes += Number(static_cast<float>(i));
  return bytes;
}

TEST_F(MissionFiles, GeoidInterpolatesAndWrapsAroundTheEarth) {
  const std::filesystem::path grid = folder_ / "grid.gtx";
  WriteFileAtomically(grid, Grid());
  EXPECT_NEAR(*GeoidUndulation(-90, -180, grid), 0, 1e-12);
  EXPECT_NEAR(*GeoidUndulation(0, 0, grid), 6, 1e-12);
  EXPECT_NEAR(*GeoidUndulation(45, 45, grid), (6 + 7 + 10 + 11) / 4.0, 1e-12);
  EXPECT_NEAR(*GeoidUndulation(90, 90, grid), 11, 1e-12);
  EXPECT_NEAR(*GeoidUndulation(0, 135, grid), (7 + 4) / 2.0, 1e-12);  // from 90 to 180 = -180
  EXPECT_FALSE(GeoidUndulation(0, 0, folder_ / "none.gtx").has_value());
}

TEST_F(MissionFiles, GeoidRefusesAFileThatIsNoGrid) {
  WriteFileAtomically(folder_ / "short.gtx", "not a grid");
  EXPECT_THROW(GeoidUndulation(0, 0, folder_ / "short.gtx"), Error);
  WriteFileAtomically(folder_ / "cut.gtx", Grid().substr(0, 60));
  EXPECT_THROW(GeoidUndulation(0, 0, folder_ / "cut.gtx"), Error);
}

// GDAL reads the same file on its own.
TEST_F(MissionFiles, GeoidAgreesWithGdal) {
  if (!std::filesystem::exists(kEgm96Grid)) GTEST_SKIP() << "no " << kEgm96Grid;
  // Nodes of its grid, where it need not interpolate.
  for (const auto& [lat, lon] :
       {std::pair{47.5, 8.5}, {-34.0, 151.25}, {7.0, 80.0}, {64.0, -22.0}}) {
    const std::string text = Output({"gdallocationinfo", "-valonly", "-wgs84", kEgm96Grid,
                                     std::to_string(lon), std::to_string(lat)});
    if (text.empty()) FAIL();
    EXPECT_NEAR(*GeoidUndulation(lat, lon), std::stod(text), 1e-4) << lat << " " << lon;
  }
  EXPECT_NEAR(*GeoidUndulation(47.4, 8.5), 48, 1.5);  // Switzerland
  EXPECT_NEAR(*GeoidUndulation(6.9, 79.9), -97, 3);   // Sri Lanka: the deepest
}

}  // namespace
}  // namespace colmap_ext
