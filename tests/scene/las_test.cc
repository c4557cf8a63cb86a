#include "colmap_ext/scene/las.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "test_folder.h"

namespace colmap_ext {
namespace {

template <typename T>
void Put(std::string* bytes, std::size_t offset, T value) {
  std::memcpy(bytes->data() + offset, &value, sizeof value);
}

// Two points of format 0 (20 bytes a record): (1, -2, 3) and (0.5, 0, 250.25) after scale 0.25 and
// offset (100, 200, 0).
std::string TwoPoints(int minor) {
  const std::size_t header = minor >= 4 ? 375 : 227;
  std::string bytes(header + 40, '\0');
  bytes.replace(0, 4, "LASF");
  bytes[24] = 1;
  bytes[25] = static_cast<char>(minor);
  Put(&bytes, 94, static_cast<std::uint16_t>(header));
  Put(&bytes, 96, static_cast<std::uint32_t>(header));
  Put(&bytes, 105, std::uint16_t{20});
  if (minor >= 4) {
    Put(&bytes, 247, std::uint64_t{2});
  } else {
    Put(&bytes, 107, std::uint32_t{2});
  }
  for (const std::size_t k : {0, 1, 2}) Put(&bytes, 131 + 8 * k, 0.25);
  Put(&bytes, 155, 100.0);
  Put(&bytes, 163, 200.0);
  const std::int32_t raw[2][3] = {{-396, -808, 12}, {-398, -800, 1001}};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 3; ++k) Put(&bytes, header + 20 * i + 4 * k, raw[i][k]);
  }
  return bytes;
}

class LasTest : public testing::Test {
 protected:
  std::vector<Eigen::Vector3d> Read(const std::string& bytes) {
    WriteFileAtomically(folder_ / "scan.las", bytes);
    return ReadLasPoints(folder_ / "scan.las");
  }

  TestFolder folder_;
};

TEST_F(LasTest, ReadsEveryVersion) {
  for (const int minor : {0, 2, 4}) {
    const auto points = Read(TwoPoints(minor));
    ASSERT_EQ(points.size(), 2u) << minor;
    EXPECT_EQ(points[0], Eigen::Vector3d(1, -2, 3));
    EXPECT_EQ(points[1], Eigen::Vector3d(0.5, 0, 250.25));
  }
}

TEST_F(LasTest, SaysWhatIsWrong) {
  std::string compressed = TwoPoints(2);
  compressed[104] = static_cast<char>(0x80);
  ExpectError([&] { Read(compressed); }, {"scan.las", "LAZ"});
  ExpectError([&] { Read("LASF"); }, {"scan.las", "not a LAS file"});
  ExpectError([&] { Read(std::string(500, 'x')); }, {"not a LAS file"});
  std::string not_finite = TwoPoints(2);
  Put(&not_finite, 155, std::numeric_limits<double>::quiet_NaN());
  ExpectError([&] { Read(not_finite); }, {"point 0", "finite"});
}

TEST_F(LasTest, NoTruncationIsReadAsPoints) {
  for (const int minor : {2, 4}) {
    const std::string bytes = TwoPoints(minor);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      EXPECT_THROW(Read(bytes.substr(0, length)), Error) << minor << " " << length;
    }
  }
}

}  // namespace
}  // namespace colmap_ext
