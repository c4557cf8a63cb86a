#include "colmap_ext/util/utc_time.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>

namespace colmap_ext {

std::string UtcText(std::uint64_t us_since_1970, int digits) {
  const auto seconds = static_cast<std::time_t>(us_since_1970 / 1'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> date{}, fraction{};
  std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  const auto us = static_cast<unsigned>(us_since_1970 % 1'000'000);
  std::snprintf(fraction.data(), fraction.size(), ".%06u", us);
  const std::string point_and_digits =
      digits > 0 ? std::string(fraction.data(), static_cast<std::size_t>(digits) + 1) : "";
  return date.data() + point_and_digits + "Z";
}

std::string UtcNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  return UtcText(static_cast<std::uint64_t>(us), 3);
}

}  // namespace colmap_ext
