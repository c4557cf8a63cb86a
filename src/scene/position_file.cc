#include "colmap_ext/scene/position_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/shortest_digits.h"
#include "scene/text_numbers.h"

namespace colmap_ext {
namespace {

struct PositionLine {
  std::size_t number = 0;  // from 1
  std::string name;
  std::vector<std::string_view> columns;  // behind the name
};

[[noreturn]] void Fail(const std::filesystem::path& path, std::size_t line,
                       const std::string& message) {
  throw Error(path.string() + ": line " + std::to_string(line) + ": " + message);
}

std::string_view Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::vector<std::string_view> SplitColumns(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return SplitWords(line);
  std::vector<std::string_view> columns;
  while (true) {
    const auto comma = line.find(',');
    columns.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return columns;
    line.remove_prefix(comma + 1);
  }
}

// Lines that hold something, comments left out. The views point into `text`.
std::vector<PositionLine> SplitLines(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::size_t offset = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  std::vector<PositionLine> lines;
  for (std::size_t number = 1;; ++number) {
    const auto line = NextLine(text, &offset);
    if (!line) return lines;
    const std::string_view content = Trimmed(*line);
    if (content.empty() || content[0] == '#') continue;
    const auto columns = SplitColumns(content);
    lines.push_back({number, std::string(columns[0]), {columns.begin() + 1, columns.end()}});
  }
}

// The first three columns behind the name. `columns`: what they are, for the message.
Eigen::Vector3d ParsePosition(const PositionLine& line, const std::string& columns,
                              const std::filesystem::path& path) {
  if (line.columns.size() < 3) Fail(path, line.number, "expected '" + columns + "'");
  Eigen::Vector3d position;
  for (int i = 0; i < 3; ++i) {
    const std::string_view word = line.columns[static_cast<std::size_t>(i)];
    const auto value = ParseNumber(word);
    if (!value || !std::isfinite(*value)) {
      Fail(path, line.number,
           "'" + std::string(word.substr(0, 40)) + "' is no number; expected '" + columns + "'");
    }
    position[i] = *value;
  }
  return position;
}

template <typename Position>
void Insert(const PositionLine& line, const Position& position, const std::filesystem::path& path,
            std::map<std::string, Position>* positions) {
  if (!positions->emplace(line.name, position).second) {
    Fail(path, line.number, "photo " + line.name + " is named twice");
  }
}

// Drops OpenDroneMap's first line, the coordinate system.
void TakeCoordinateSystem(const std::filesystem::path& path, std::vector<PositionLine>* lines) {
  if (lines->empty()) return;
  const PositionLine& first = lines->front();
  const bool is_system = first.name.starts_with("EPSG:") || first.name.starts_with("epsg:") ||
                         first.name.starts_with("+proj") || first.name == "WGS84";
  if (!is_system) return;
  if ((first.name != "EPSG:4326" && first.name != "epsg:4326") || !first.columns.empty()) {
    Fail(path, first.number,
         "coordinate system " + first.name +
             " is not supported; convert the positions to longitude and latitude (EPSG:4326)");
  }
  lines->erase(lines->begin());
}

}  // namespace

std::map<std::string, GeoPosition> ReadGeoFile(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  std::vector<PositionLine> lines = SplitLines(text);
  TakeCoordinateSystem(path, &lines);
  std::map<std::string, GeoPosition> positions;
  for (const PositionLine& line : lines) {
    const Eigen::Vector3d lon_lat_alt = ParsePosition(line, "name lon lat alt", path);
    const GeoPosition position{
        .lat_deg = lon_lat_alt.y(), .lon_deg = lon_lat_alt.x(), .height_m = lon_lat_alt.z()};
    if (!IsValid(position)) {
      Fail(path, line.number,
           "longitude or latitude is out of range; the order is 'name lon lat alt', in degrees");
    }
    Insert(line, position, path, &positions);
  }
  if (positions.empty()) throw Error(path.string() + ": no line names a photo");
  return positions;
}

std::map<std::string, Eigen::Vector3d> ReadPosePriorFile(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  std::map<std::string, Eigen::Vector3d> positions;
  for (const PositionLine& line : SplitLines(text)) {
    if (line.columns.size() != 3) Fail(path, line.number, "expected 'name x y z' (metres)");
    Insert(line, ParsePosition(line, "name x y z", path), path, &positions);
  }
  if (positions.empty()) throw Error(path.string() + ": no line names a photo");
  return positions;
}

void WritePosePriorFile(const std::map<std::string, Eigen::Vector3d>& position_of_photo,
                        const std::filesystem::path& path) {
  std::string text = "# name x y z (metres)\n";
  for (const auto& [name, position] : position_of_photo) {
    if (!position.allFinite() || name.empty() || name.find_first_of(",\r\n") != std::string::npos) {
      throw Error(path.string() + ": the position of photo '" + name + "' cannot be written");
    }
    const char* separator = name.find_first_of(" \t") == std::string::npos ? " " : ",";
    text += name;
    for (int i = 0; i < 3; ++i) text += separator + ShortestDigits(position[i]);
    text += "\n";
  }
  WriteFileAtomically(path, text);
}

}  // namespace colmap_ext
