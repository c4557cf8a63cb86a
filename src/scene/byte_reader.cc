#include "scene/byte_reader.h"

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

ByteReader::ByteReader(std::filesystem::path path)
    : path_(std::move(path)), content_(ReadFile(path_)) {}

void ByteReader::Take(void* destination, std::size_t num_bytes, const char* what) {
  if (num_bytes > remaining()) {
    Fail("the file ends inside " + std::string(what) + "; it is truncated, write it again");
  }
  if (num_bytes == 0) return;
  std::memcpy(destination, content_.data() + offset_, num_bytes);
  offset_ += num_bytes;
}

std::string ByteReader::ReadCString(const char* what) {
  const std::size_t end = content_.find('\0', offset_);
  if (end == std::string::npos) {
    Fail("the file ends inside " + std::string(what) + "; it is truncated, write it again");
  }
  std::string text = content_.substr(offset_, end - offset_);
  offset_ = end + 1;
  return text;
}

std::size_t ByteReader::ReadCount(std::size_t min_record_bytes, const char* what) {
  const std::size_t start = offset_;
  const auto count = Read<std::uint64_t>(what);
  if (count > remaining() / min_record_bytes) {
    offset_ = start;
    Fail(std::string(what) + " is " + std::to_string(count) +
         ", more than fits into the rest of the file; it is truncated or corrupt, write it again");
  }
  return static_cast<std::size_t>(count);
}

void ByteReader::ExpectEnd() const {
  if (remaining() == 0) return;
  Fail(std::to_string(remaining()) +
       " bytes follow the last record; the file is corrupt or not of this kind, write it again");
}

void ByteReader::Fail(const std::string& problem) const {
  throw Error(path_.string() + ": byte " + std::to_string(offset_) + ": " + problem);
}

}  // namespace colmap_ext
