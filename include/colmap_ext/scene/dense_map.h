// COLMAP's depth and normal maps (stereo/depth_maps, stereo/normal_maps): the ASCII header
// `width&height&channels&`, then float32, little-endian, one whole channel after the other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace colmap_ext {

struct DenseMap {
  int width = 0;   // px, 1 … 65536
  int height = 0;  // px, 1 … 65536
  int channels =
      0;  // 1 depth along the optical axis (<= 0: none), 3 normal in the camera frame; … 16
  std::vector<float>
      data;  // width * height * channels, index (channel * height + row) * width + col

  DenseMap() = default;
  // All zero.
  DenseMap(int width, int height, int channels);

  float& At(int row, int col, int channel = 0) { return data[Index(row, col, channel)]; }
  float At(int row, int col, int channel = 0) const { return data[Index(row, col, channel)]; }

 private:
  std::size_t Index(int row, int col, int channel) const {
    return (static_cast<std::size_t>(channel) * static_cast<std::size_t>(height) +
            static_cast<std::size_t>(row)) *
               static_cast<std::size_t>(width) +
           static_cast<std::size_t>(col);
  }
};

// Throws Error naming the file and what is wrong: a malformed header, sizes outside the ranges
// above, or a size of the file that is not what the header says.
DenseMap ReadDenseMap(const std::filesystem::path& path);
// Replaces the file atomically. Throws Error when sizes and data disagree.
void WriteDenseMap(const DenseMap& map, const std::filesystem::path& path);

}  // namespace colmap_ext
