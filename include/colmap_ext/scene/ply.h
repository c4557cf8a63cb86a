// PLY files (Stanford polygon format 1.0): a table per element. The typed readers and writers of
// meshes, points and coverage maps stand on this one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace colmap_ext {

enum class PlyType {
  kInt8,
  kUInt8,
  kInt16,
  kUInt16,
  kInt32,
  kUInt32,
  kFloat32,
  kFloat64,
};

// One number a row. Every PLY type is exact in a double.
struct PlyScalar {
  std::string name;
  PlyType type = PlyType::kFloat64;
  std::vector<double> values;  // size = rows of the element
};

// A list of numbers a row (the corners of a face): row i holds items[starts[i]] … items[starts[i+1]
// - 1].
struct PlyList {
  std::string name;
  PlyType count_type = PlyType::kUInt8;
  PlyType item_type = PlyType::kInt32;
  std::vector<std::size_t> starts = {0};  // size = rows + 1
  std::vector<double> items;

  std::size_t NumRows() const { return starts.size() - 1; }
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;  // rows
  std::vector<PlyScalar> scalars;
  std::vector<PlyList> lists;

  const PlyScalar* FindScalar(std::string_view scalar_name) const;  // nullptr: not there
  const PlyList* FindList(std::string_view list_name) const;
};

struct PlyData {
  std::vector<std::string> comments;  // without the word "comment"
  std::vector<PlyElement> elements;

  const PlyElement* FindElement(std::string_view name) const;  // nullptr: not there
};

// Reads ASCII and binary little-endian files. Nothing is allocated that the file's size does not
// justify, whatever its header promises. Throws Error naming the file and the line (header, ASCII)
// or byte offset (binary) of what is missing, left over or malformed.
PlyData ReadPly(const std::filesystem::path& path);

// Writes binary little-endian, atomically, scalars before lists. Throws Error when columns differ
// in length from their element, or a value does not fit its integer type.
void WritePly(const PlyData& data, const std::filesystem::path& path);

}  // namespace colmap_ext
