#include "colmap_ext/scene/dense_map.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>

#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"

namespace colmap_ext {
namespace {

DenseMap MakeMap(int width, int height, int channels) {
  DenseMap map(width, height, channels);
  for (std::size_t i = 0; i < map.data.size(); ++i) map.data[i] = 0.5f * static_cast<float>(i) - 3;
  return map;
}

void WriteRaw(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

TEST(DenseMap, DepthAndNormalMapsComeBack) {
  TestFolder folder;
  for (const int channels : {1, 3}) {
    DenseMap map = MakeMap(13, 7, channels);
    map.data[4] = std::numeric_limits<float>::quiet_NaN();  // a value is a value
    WriteDenseMap(map, folder / "stereo/depth_maps/a.jpg.geometric.bin");
    const DenseMap back = ReadDenseMap(folder / "stereo/depth_maps/a.jpg.geometric.bin");
    EXPECT_EQ(back.width, 13);
    EXPECT_EQ(back.height, 7);
    EXPECT_EQ(back.channels, channels);
    ASSERT_EQ(back.data.size(), map.data.size());
    EXPECT_EQ(std::memcmp(back.data.data(), map.data.data(), map.data.size() * 4), 0);
  }
}

TEST(DenseMap, LayoutIsColmaps) {
  // channel after channel, row after row: index c * W * H + row * W + col
  TestFolder folder;
  DenseMap map(4, 3, 2);
  map.At(2, 1, 1) = 42;
  EXPECT_EQ(map.data[1 * 4 * 3 + 2 * 4 + 1], 42);
  WriteDenseMap(map, folder / "m.bin");
  const std::string content = ReadFile(folder / "m.bin");
  ASSERT_EQ(content.size(), 6u + 4u * 3u * 2u * 4u);
  EXPECT_EQ(content.substr(0, 6), "4&3&2&");
  float value = 0;
  std::memcpy(&value, content.data() + 6 + 4 * (1 * 4 * 3 + 2 * 4 + 1), 4);
  EXPECT_EQ(value, 42);
}

TEST(DenseMap, TruncatedOrOversizedAtAnyByteIsAnError) {
  TestFolder folder;
  WriteDenseMap(MakeMap(12, 5, 3), folder / "m.bin");
  const std::string content = ReadFile(folder / "m.bin");
  for (std::size_t size = content.size() - 1; size > 0; --size) {
    std::filesystem::resize_file(folder / "m.bin", size);
    EXPECT_ERROR_HAS(ReadDenseMap(folder / "m.bin"), "m.bin: byte ");
  }
  std::filesystem::resize_file(folder / "m.bin", 0);
  EXPECT_ERROR_HAS(ReadDenseMap(folder / "m.bin"), "m.bin: ");
  WriteRaw(folder / "m.bin", content + "x");
  EXPECT_ERROR_HAS(ReadDenseMap(folder / "m.bin"), "truncated or corrupt");
}

TEST(DenseMap, MalformedHeadersAreErrors) {
  TestFolder folder;
  const std::string floats(4, '\0');
  for (const char* header :
       {"", "&", "1&1&", "1&1&1", "-1&1&1&", "0&1&1&", "1&0&1&", "1&1&0&", " 1&1&1&", "1.0&1&1&",
        "a&1&1&", "1,1,1,", "65537&1&1&", "1&65537&1&", "1&1&17&", "99999999999999999999&1&1&",
        "1000000&1&1&", "\xff\xd8\xff\xe0", "1&&1&"}) {
    WriteRaw(folder / "m.bin", header + floats);
    EXPECT_ERROR_HAS(ReadDenseMap(folder / "m.bin"), (folder / "m.bin").string());
  }
}

TEST(DenseMap, HugeHeaderOfASmallFileIsAnErrorAtOnce) {
  TestFolder folder;
  WriteRaw(folder / "m.bin", "65536&65536&16&abcd");  // would be 256 GiB
  EXPECT_ERROR_HAS(ReadDenseMap(folder / "m.bin"), "the file has 4");
}

TEST(DenseMap, MissingFileIsNamed) {
  EXPECT_ERROR_HAS(ReadDenseMap("/nonexistent/m.bin"), "/nonexistent/m.bin");
}

TEST(DenseMap, WrongSizesAreNotWritten) {
  TestFolder folder;
  DenseMap map = MakeMap(4, 4, 1);
  map.data.pop_back();
  EXPECT_ERROR_HAS(WriteDenseMap(map, folder / "m.bin"), "with 15 values");
  map = MakeMap(4, 4, 1);
  map.width = -4;
  map.height = -4;
  EXPECT_ERROR_HAS(WriteDenseMap(map, folder / "m.bin"), "cannot be written");
  EXPECT_FALSE(std::filesystem::exists(folder / "m.bin"));
}

}  // namespace
}  // namespace colmap_ext
