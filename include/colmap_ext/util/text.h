// Text for people, and from them.
#pragma once

#include <string>
#include <vector>

namespace colmap_ext {

// printf's text of `format`, which has one conversion of a double; at most 63 characters.
std::string FormatNumber(const char* format, double value);

// The parts between commas, spaces kept; "a,,b" has an empty part, "" and what follows a last comma
// are none.
std::vector<std::string> SplitAtCommas(const std::string& text);

}  // namespace colmap_ext
