#include "colmap_ext/scene/coverage_map_io.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "scene/ply_columns.h"
#include "scene/text_numbers.h"

namespace colmap_ext {
namespace {

Rgb8 ClassColor(CoverageClass coverage) {
  switch (coverage) {
    case CoverageClass::kUncovered:
      return {220, 40, 40};
    case CoverageClass::kCovered:
      return {40, 180, 60};
    case CoverageClass::kIgnored:
      break;
  }
  return {50, 90, 220};
}

// "name 0.25" with the shortest digits that read back to the same number.
std::string NumberComment(const std::string& name, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return name + " " + std::string(digits.data(), end);
}

std::optional<double> FindInComments(const PlyData& data, const std::string& name) {
  for (const std::string& comment : data.comments) {
    const auto words = SplitWords(comment);
    if (words.size() != 2 || words[0] != name) continue;
    const auto value = ParseNumber(words[1]);
    if (value && std::isfinite(*value)) return value;
  }
  return std::nullopt;
}

double NumberFromComments(const PlyData& data, const std::string& name,
                          const std::filesystem::path& path) {
  if (const auto value = FindInComments(data, name)) return *value;
  throw Error(path.string() + ": the header has no line 'comment " + name +
              " <number>'; was this coverage map saved by another program?");
}

void CheckWritable(const CoverageMap& map, const std::string& path) {
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const IsoPoint& point = map.points[i];
    if (!point.position.allFinite() || !point.normal.allFinite() ||
        !std::isfinite(point.sample_spacing_m) || !std::isfinite(point.scatter_m) ||
        !std::isfinite(point.best_projection_ratio) || !std::isfinite(point.predicted_error_mm) ||
        !std::isfinite(point.score)) {
      throw Error(path + ": iso-point " + std::to_string(i) + " is not finite");
    }
  }
  if (!std::isfinite(map.disk_area_m2) || !std::isfinite(map.min_projection_ratio) ||
      !std::isfinite(map.target_error_mm)) {
    throw Error(
        path +
        ": disk_area_m2, min_projection_ratio or target_error_mm of the coverage map is not "
        "finite");
  }
}

PlyElement ElementFromPoints(const std::vector<IsoPoint>& points) {
  const std::size_t count = points.size();
  std::vector<Eigen::Vector3d> positions(count), normals(count);
  std::vector<Rgb8> colors(count);
  std::vector<double> classes(count), views(count), spacing(count), scatter(count), ratio(count),
      error(count), score(count);
  for (std::size_t i = 0; i < count; ++i) {
    positions[i] = points[i].position;
    normals[i] = points[i].normal;
    colors[i] = ClassColor(points[i].coverage);
    classes[i] = static_cast<double>(points[i].coverage);
    views[i] = points[i].num_good_views;
    spacing[i] = points[i].sample_spacing_m;
    scatter[i] = points[i].scatter_m;
    ratio[i] = points[i].best_projection_ratio;
    error[i] = points[i].predicted_error_mm;
    score[i] = points[i].score;
  }
  PlyElement rows;
  rows.name = "vertex";
  rows.count = count;
  AddVectors(kPositionColumns, positions, &rows);
  AddVectors(kNormalColumns, normals, &rows);
  AddColors(colors, &rows);
  AddNumbers("class", PlyType::kUInt8, std::move(classes), &rows);
  AddNumbers("num_good_views", PlyType::kInt32, std::move(views), &rows);
  AddNumbers("sample_spacing_m", PlyType::kFloat64, std::move(spacing), &rows);
  AddNumbers("scatter_m", PlyType::kFloat64, std::move(scatter), &rows);
  AddNumbers("best_projection_ratio", PlyType::kFloat64, std::move(ratio), &rows);
  AddNumbers("predicted_error_mm", PlyType::kFloat64, std::move(error), &rows);
  AddNumbers("score", PlyType::kFloat64, std::move(score), &rows);
  return rows;
}

// Of the points that have to be covered.
Json ErrorSummary(const CoverageMap& map) {
  std::vector<double> errors;
  std::size_t none = 0;
  for (const IsoPoint& point : map.points) {
    if (point.coverage == CoverageClass::kIgnored) continue;
    if (point.predicted_error_mm < 0) {
      ++none;
    } else {
      errors.push_back(point.predicted_error_mm);
    }
  }
  std::sort(errors.begin(), errors.end());
  Json summary = {{"without", none}};
  if (errors.empty()) return summary;
  const auto at = [&errors](double part) {
    return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size() - 1))];
  };
  summary["median"] = at(0.5);
  summary["percentile90"] = at(0.9);
  return summary;
}

}  // namespace

CoverageMap ReadCoverageMap(const std::filesystem::path& path) {
  const PlyData data = ReadPly(path);
  const ColumnReader rows(data, "vertex", path);
  CoverageMap map;
  map.disk_area_m2 = NumberFromComments(data, "disk_area_m2", path);
  map.min_projection_ratio = NumberFromComments(data, "min_projection_ratio", path);
  map.target_error_mm = FindInComments(data, "target_error_mm").value_or(0);
  const auto positions = rows.Vectors(kPositionColumns);
  const auto normals = rows.Vectors(kNormalColumns);
  const auto classes = rows.Integers("class", 0, static_cast<int>(CoverageClass::kIgnored));
  const auto views = rows.Integers("num_good_views", 0, std::numeric_limits<int>::max());
  const auto& spacing = rows.Numbers("sample_spacing_m");
  const auto& ratio = rows.Numbers("best_projection_ratio");
  const auto& error = rows.Numbers("predicted_error_mm");
  // Maps of earlier versions have neither.
  const bool has_score = rows.Has("score"), has_scatter = rows.Has("scatter_m");
  map.points.resize(rows.NumRows());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    map.points[i] = {.position = positions[i],
                     .normal = normals[i],
                     .coverage = static_cast<CoverageClass>(classes[i]),
                     .sample_spacing_m = spacing[i],
                     .scatter_m = has_scatter ? rows.Numbers("scatter_m")[i] : 0.0,
                     .num_good_views = views[i],
                     .best_projection_ratio = ratio[i],
                     .predicted_error_mm = error[i],
                     .score = has_score ? rows.Numbers("score")[i] : 0.0};
  }
  return map;
}

void WriteCoverageMap(const CoverageMap& map, const std::filesystem::path& path) {
  CheckWritable(map, path.string());
  PlyData data;
  data.comments = {"class: 0 uncovered (red), 1 covered (green), 2 ignored (blue)",
                   NumberComment("disk_area_m2", map.disk_area_m2),
                   NumberComment("min_projection_ratio", map.min_projection_ratio),
                   NumberComment("target_error_mm", map.target_error_mm)};
  data.elements.push_back(ElementFromPoints(map.points));
  WritePly(data, path);
}

void WriteCoverageSummary(const CoverageMap& map, const std::map<std::string, double>& thresholds,
                          const std::filesystem::path& path) {
  const std::size_t covered = map.Count(CoverageClass::kCovered);
  const std::size_t uncovered = map.Count(CoverageClass::kUncovered);
  Json summary;
  summary["covered"] = covered;
  summary["uncovered"] = uncovered;
  summary["ignored"] = map.Count(CoverageClass::kIgnored);
  summary["covered_ratio"] = map.CoveredRatio();
  summary["area_m2"] = map.disk_area_m2 * static_cast<double>(covered + uncovered);
  summary["predicted_error_mm"] = ErrorSummary(map);
  summary["thresholds"] = {{"min_projection_ratio", map.min_projection_ratio}};
  for (const auto& [name, value] : thresholds) summary["thresholds"][name] = value;
  WriteJsonFile(summary, path);
}

}  // namespace colmap_ext
