#include "scene/text_numbers.h"

#include <charconv>
#include <system_error>

namespace colmap_ext {

std::optional<double> ParseNumber(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> SplitWords(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(separators);
  while (begin != std::string_view::npos) {
    const std::size_t end = line.find_first_of(separators, begin);
    words.push_back(line.substr(begin, end == std::string_view::npos ? end : end - begin));
    begin = line.find_first_not_of(separators, end);
  }
  return words;
}

std::optional<std::string_view> NextLine(std::string_view text, std::size_t* offset) {
  if (*offset >= text.size()) return std::nullopt;
  const std::size_t end = text.find('\n', *offset);
  std::string_view line = text.substr(*offset, end == std::string_view::npos ? end : end - *offset);
  *offset = end == std::string_view::npos ? text.size() : end + 1;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

}  // namespace colmap_ext
