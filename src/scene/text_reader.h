// Lines and columns of COLMAP's text files, with the line in every error.
#pragma once

#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace colmap_ext {

class TextReader {
 public:
  // Reads the whole file. Throws Error when it is missing, unreadable, or does not end with a line
  // end: then its last number may be half of itself.
  explicit TextReader(std::filesystem::path path);

  // Next line, without its end; false after the last.
  bool NextLine();
  // Next line that is neither empty nor a comment (#).
  bool NextRecord();

  // Next column of the present line; nullopt when there is none left.
  std::optional<std::string_view> NextWord();
  // Next column as a number. Throws Error naming file, line and `what`.
  template <typename T>
  T Next(const char* what) {
    const std::optional<std::string_view> word = NextWord();
    if (!word) Fail("there is no column for " + std::string(what));
    return Parse<T>(*word, what);
  }
  template <typename T>
  T Parse(std::string_view word, const char* what) const {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      Fail("'" + std::string(word) + "' is not a valid number for " + what);
    }
    return value;
  }
  // What is left of the line, without blanks around it.
  std::string Rest();
  // Throws Error when the line has more columns.
  void ExpectLineEnd();

  // Throws Error "<file>: line <n>: <problem>".
  [[noreturn]] void Fail(const std::string& problem) const;

 private:
  void SkipBlanks();

  std::filesystem::path path_;
  std::string content_;
  std::size_t next_line_ = 0;
  std::size_t line_number_ = 0;
  std::string_view line_;
};

}  // namespace colmap_ext
