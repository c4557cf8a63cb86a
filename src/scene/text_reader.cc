#include "scene/text_reader.h"

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

}  // namespace

TextReader::TextReader(std::filesystem::path path)
    : path_(std::move(path)), content_(ReadFile(path_)) {
  if (content_.empty() || content_.back() != '\n') {
    throw Error(path_.string() +
                ": does not end with a line end; it may be truncated: write it again, or end its "
                "last line if it is complete");
  }
}

bool TextReader::NextLine() {
  if (next_line_ >= content_.size()) return false;
  const std::size_t end = content_.find('\n', next_line_);
  line_ = std::string_view(content_).substr(next_line_, end - next_line_);
  next_line_ = end + 1;
  ++line_number_;
  return true;
}

bool TextReader::NextRecord() {
  while (NextLine()) {
    SkipBlanks();
    if (!line_.empty() && line_.front() != '#') return true;
  }
  return false;
}

void TextReader::SkipBlanks() {
  while (!line_.empty() && IsBlank(line_.front())) line_.remove_prefix(1);
}

std::optional<std::string_view> TextReader::NextWord() {
  SkipBlanks();
  if (line_.empty()) return std::nullopt;
  std::size_t length = 0;
  while (length < line_.size() && !IsBlank(line_[length])) ++length;
  const std::string_view word = line_.substr(0, length);
  line_.remove_prefix(length);
  return word;
}

std::string TextReader::Rest() {
  SkipBlanks();
  while (!line_.empty() && IsBlank(line_.back())) line_.remove_suffix(1);
  std::string rest(line_);
  line_ = {};
  return rest;
}

void TextReader::ExpectLineEnd() {
  const std::string rest = Rest();
  if (!rest.empty()) Fail("there are too many columns, from '" + rest.substr(0, 40) + "' on");
}

void TextReader::Fail(const std::string& problem) const {
  throw Error(path_.string() + ": line " + std::to_string(line_number_) + ": " + problem);
}

}  // namespace colmap_ext
