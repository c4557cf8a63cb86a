// Numbers in text files, independent of the locale.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace colmap_ext {

// The whole of `text` as a number; a leading '+', "nan" and "inf" are understood.
std::optional<double> ParseNumber(std::string_view text);

// The words of a line, separated by any of `separators`.
std::vector<std::string_view> SplitWords(std::string_view line,
                                         std::string_view separators = " \t");

// The next line of `text` from `*offset` (moved behind it), without its line end (\n or \r\n).
// nullopt at the end of the text.
std::optional<std::string_view> NextLine(std::string_view text, std::size_t* offset);

}  // namespace colmap_ext
