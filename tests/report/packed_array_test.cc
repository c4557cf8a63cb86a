#include "report/packed_array.h"

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <limits>
#include <random>

#include "colmap_ext/report/view_overlay.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// The reader, as its description says.
std::vector<std::int64_t> Unpack(const Json& packed) {
  const std::string text = packed["data"].get<std::string>();
  std::vector<unsigned char> deflated(text.size());
  const int length =
      EVP_DecodeBlock(deflated.data(), reinterpret_cast<const unsigned char*>(text.data()),
                      static_cast<int>(text.size()));
  EXPECT_GE(length, 0);
  std::vector<unsigned char> bytes(1 << 22);
  uLongf size = bytes.size();
  EXPECT_EQ(uncompress(bytes.data(), &size, deflated.data(), static_cast<uLong>(length)), Z_OK);
  const auto components = packed["components"].get<std::size_t>();
  std::vector<std::int64_t> values;
  for (std::size_t at = 0; at < size;) {
    std::uint64_t code = 0;
    for (int shift = 0;; shift += 7) {
      code |= static_cast<std::uint64_t>(bytes[at] & 0x7f) << shift;
      if ((bytes[at++] & 0x80) == 0) break;
    }
    const auto half = static_cast<std::int64_t>(code >> 1);
    const std::int64_t difference = code % 2 == 0 ? half : -half - 1;
    values.push_back(difference +
                     (values.size() < components ? 0 : values[values.size() - components]));
  }
  EXPECT_EQ(values.size(), components * packed["count"].get<std::size_t>());
  return values;
}

TEST(PackIntegers, ComesBack) {
  std::mt19937 random(1);
  for (const int components : {1, 2, 3}) {
    std::vector<std::int32_t> values = {std::numeric_limits<std::int32_t>::max(),
                                        std::numeric_limits<std::int32_t>::min(),
                                        0,
                                        -1,
                                        1,
                                        127};
    while (values.size() < 6000)
      values.push_back(static_cast<std::int32_t>(random()) >> (random() % 32));
    const std::vector<std::int64_t> read = Unpack(PackIntegers(values, components));
    EXPECT_TRUE(std::equal(values.begin(), values.end(), read.begin(), read.end()));
  }
  EXPECT_TRUE(Unpack(PackIntegers({}, 3)).empty());
  const std::vector<std::int32_t> four(4);
  EXPECT_THROW(PackIntegers(four, 3), Error);
  EXPECT_THROW(PackIntegers(four, 0), Error);
}

TEST(PackPositions, IsWithinHalfAStep) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> coordinate(-40, 40);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 500; ++i) {
    points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  }
  const Eigen::Vector3d origin(3, -2, 1);
  const std::vector<std::int64_t> steps = Unpack(PackPositions(points, origin, 0.01));
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      EXPECT_NEAR(origin[axis] + 0.01 * static_cast<double>(steps[3 * i + k]), points[i][axis],
                  0.00501);
    }
  }
  EXPECT_EQ(Unpack(PackPositions({Eigen::Vector3d(1e30, 0, -1e30)}, {0, 0, 0}, 1))[0], 1 << 30);
  EXPECT_THROW(PackPositions(points, origin, 0), Error);
}

TEST(SpatialOrder, MakesDifferencesSmall) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(0, 100);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 3000; ++i) points.emplace_back(coordinate(random), coordinate(random), 0);
  const std::vector<std::size_t> order = SpatialOrder(points);
  std::vector<bool> seen(points.size());
  double sorted = 0, unsorted = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_FALSE(seen[order[i]]);
    seen[order[i]] = true;
    if (i == 0) continue;
    sorted += (points[order[i]] - points[order[i - 1]]).norm();
    unsorted += (points[i] - points[i - 1]).norm();
  }
  EXPECT_LT(10 * sorted, unsorted);
  EXPECT_TRUE(SpatialOrder({}).empty());
  EXPECT_EQ(SpatialOrder(std::vector<Eigen::Vector3d>(2, {1, 1, 1})).size(), 2U);
}

TEST(WriteViewOverlays, RefusesWhatDoesNotFit) {
  PhotoSet photos;
  photos.photos.resize(1);
  EXPECT_THROW(WriteViewOverlays(photos, {}, ::testing::TempDir() + "/o.json"), Error);
  std::vector<ViewMesh> views(1);
  views[0].image.triangles = {{0, 1, 2}};
  EXPECT_THROW(WriteViewOverlays(photos, views, ::testing::TempDir() + "/o.json"), Error);
}

}  // namespace
}  // namespace colmap_ext
