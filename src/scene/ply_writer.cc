#include <ostream>
#include <string>

#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/ply_types.h"

namespace colmap_ext {
namespace {

void CheckFits(double value, PlyType type, const std::string& where) {
  if (!FitsPlyType(value, type)) {
    throw Error(where + ": " + std::to_string(value) + " does not fit its type " + PlyName(type));
  }
}

// A value that cannot be written must be found before the file is opened for writing.
void CheckElement(const PlyElement& element, const std::string& path) {
  const std::string what = path + ": element " + element.name;
  for (const PlyScalar& scalar : element.scalars) {
    const std::string where = what + ", property " + scalar.name;
    if (scalar.values.size() != element.count) {
      throw Error(where + ": " + std::to_string(scalar.values.size()) + " values for " +
                  std::to_string(element.count) + " rows");
    }
    for (const double value : scalar.values) CheckFits(value, scalar.type, where);
  }
  for (const PlyList& list : element.lists) {
    const std::string where = what + ", list " + list.name;
    if (list.starts.size() != element.count + 1 || list.starts.front() != 0 ||
        list.starts.back() != list.items.size()) {
      throw Error(where + ": its rows do not match its items");
    }
    for (std::size_t row = 0; row < element.count; ++row) {
      if (list.starts[row] > list.starts[row + 1]) {
        throw Error(where + ": its rows do not match its items");
      }
      CheckFits(static_cast<double>(list.starts[row + 1] - list.starts[row]), list.count_type,
                where);
    }
    for (const double item : list.items) CheckFits(item, list.item_type, where);
  }
}

void AppendNumber(double value, PlyType type, std::string* out) {
  VisitPlyType(type, [value, out](auto number) {
    number = static_cast<decltype(number)>(value);
    char bytes[sizeof(number)];
    std::memcpy(bytes, &number, sizeof(number));
    out->append(bytes, sizeof(number));
  });
}

std::string Header(const PlyData& data) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : data.comments) header += "comment " + comment + "\n";
  for (const PlyElement& element : data.elements) {
    header += "element " + element.name + " " + std::to_string(element.count) + "\n";
    for (const PlyScalar& scalar : element.scalars) {
      header += std::string("property ") + PlyName(scalar.type) + " " + scalar.name + "\n";
    }
    for (const PlyList& list : element.lists) {
      header += std::string("property list ") + PlyName(list.count_type) + " " +
                PlyName(list.item_type) + " " + list.name + "\n";
    }
  }
  return header + "end_header\n";
}

void WriteRows(const PlyElement& element, std::ostream& out) {
  constexpr std::size_t kFlushBytes = 1 << 20;
  std::string buffer;
  for (std::size_t row = 0; row < element.count; ++row) {
    for (const PlyScalar& scalar : element.scalars) {
      AppendNumber(scalar.values[row], scalar.type, &buffer);
    }
    for (const PlyList& list : element.lists) {
      const std::size_t begin = list.starts[row];
      const std::size_t end = list.starts[row + 1];
      AppendNumber(static_cast<double>(end - begin), list.count_type, &buffer);
      for (std::size_t i = begin; i < end; ++i) {
        AppendNumber(list.items[i], list.item_type, &buffer);
      }
    }
    if (buffer.size() >= kFlushBytes) {
      out << buffer;
      buffer.clear();
    }
  }
  out << buffer;
}

}  // namespace

void WritePly(const PlyData& data, const std::filesystem::path& path) {
  for (const PlyElement& element : data.elements) CheckElement(element, path.string());
  for (const std::string& comment : data.comments) {
    if (comment.find_first_of("\r\n") != std::string::npos) {
      throw Error(path.string() + ": a comment must be one line");
    }
  }
  WriteFileAtomically(path, [&data](std::ostream& out) {
    out << Header(data);
    for (const PlyElement& element : data.elements) WriteRows(element, out);
  });
}

}  // namespace colmap_ext
