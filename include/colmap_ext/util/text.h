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

// `text` in lines of at most `width` bytes, broken at spaces; longer words keep a line of their
// own.
std::string WrapText(const std::string& text, std::size_t width);

// What somebody who typed `name` may have meant: the one of `names` that takes the fewest inserted,
// removed or changed letters, capitals and small ones alike, the first of several; "" when even
// that is more than a third of the letters.
std::string NearestName(const std::string& name, const std::vector<std::string>& names);
// That as " (did you mean …?)", or "".
std::string Suggestion(const std::string& name, const std::vector<std::string>& names);

}  // namespace colmap_ext
