// Numbers in text files, as short as they can be without a loss.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace colmap_ext {

// The shortest text that reads back as the same number.
inline std::string ShortestDigits(double value) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace colmap_ext
