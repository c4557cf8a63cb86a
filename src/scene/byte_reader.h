// Bounds-checked reading of little-endian binary files that are whole in memory.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <string>
#include <type_traits>

namespace colmap_ext {

static_assert(std::endian::native == std::endian::little,
              "COLMAP's files are little-endian; other machines need byte swaps here");

class ByteReader {
 public:
  // Reads the whole file. Throws Error when it is missing or unreadable.
  explicit ByteReader(std::filesystem::path path);

  // Next value. `what` names it in the error when the file ends before it.
  template <typename T>
  T Read(const char* what) {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    Take(&value, sizeof(T), what);
    return value;
  }
  // Copies `num_bytes` to `destination`.
  void Take(void* destination, std::size_t num_bytes, const char* what);
  // Characters up to a NUL, which is consumed.
  std::string ReadCString(const char* what);
  // A u64 that says how many records follow. Throws Error when so many, each of at least
  // `min_record_bytes`, do not fit into the rest of the file: a corrupt count must not make the
  // caller reserve gigabytes.
  std::size_t ReadCount(std::size_t min_record_bytes, const char* what);
  // Throws Error unless everything was read.
  void ExpectEnd() const;

  // Throws Error "<file>: byte <offset>: <problem>".
  [[noreturn]] void Fail(const std::string& problem) const;

  std::size_t offset() const { return offset_; }
  std::size_t remaining() const { return content_.size() - offset_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::string content_;
  std::size_t offset_ = 0;
};

template <typename T>
void WriteBytes(std::ostream& out, T value) {
  static_assert(std::is_arithmetic_v<T>);
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.write(bytes, sizeof(T));
}

}  // namespace colmap_ext
