// Numbers as text for people.
#pragma once

#include <string>

namespace colmap_ext {

// printf's text of `format`, which has one conversion of a double; at most 63 characters.
std::string FormatNumber(const char* format, double value);

}  // namespace colmap_ext
