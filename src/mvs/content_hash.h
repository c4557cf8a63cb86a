// Tells whether the input of a step is the one that it had before.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <type_traits>
#include <vector>

namespace colmap_ext {

// 64-bit hash of a sequence of values, by their bytes. Not meant against an adversary.
class ContentHash {
 public:
  template <typename T>
  requires std::is_arithmetic_v<T> ContentHash& Add(T value) {
    std::uint64_t word = 0;
    std::memcpy(&word, &value, sizeof value);
    return AddWord(word);
  }
  template <typename T, int rows, int cols>
  ContentHash& Add(const Eigen::Matrix<T, rows, cols>& value) {
    return AddBytes(value.data(), sizeof(T) * static_cast<std::size_t>(value.size()));
  }
  // Of numbers or fixed-size Eigen vectors: types without padding.
  template <typename T>
  ContentHash& Add(const std::vector<T>& values) {
    return Add(values.size()).AddBytes(values.data(), sizeof(T) * values.size());
  }
  ContentHash& Add(const cv::Mat& picture) {
    Add(picture.rows).Add(picture.cols).Add(picture.type());
    for (int y = 0; y < picture.rows; ++y) {
      AddBytes(picture.ptr(y), picture.elemSize() * static_cast<std::size_t>(picture.cols));
    }
    return *this;
  }

  std::uint64_t value() const { return state_; }

 private:
  ContentHash& AddWord(std::uint64_t word) {
    // A multiply and an xor-shift mix each word (constants of SplitMix64).
    state_ = (state_ ^ word) * 0xBF58476D1CE4E5B9ULL;
    state_ ^= state_ >> 29;
    return *this;
  }
  ContentHash& AddBytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (; size >= 8; size -= 8, bytes += 8) {
      std::uint64_t word;
      std::memcpy(&word, bytes, 8);
      AddWord(word);
    }
    std::uint64_t rest = size;
    if (size > 0) std::memcpy(&rest, bytes, size);
    return AddWord(rest + 0x9E3779B97F4A7C15ULL * (size + 1));
  }

  std::uint64_t state_ = 0x94D049BB133111EBULL;
};

}  // namespace colmap_ext
