// Points in time as text.
#pragma once

#include <cstdint>
#include <string>

namespace colmap_ext {

// "2026-05-04T10:11:12.345Z": ISO 8601 in UTC of microseconds since 1970, with `digits` (0 … 6)
// digits of a second, cut off, not rounded.
std::string UtcText(std::uint64_t us_since_1970, int digits);

// The system clock's present, in milliseconds.
std::string UtcNow();

}  // namespace colmap_ext
