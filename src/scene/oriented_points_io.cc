#include "colmap_ext/scene/oriented_points_io.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "scene/ply_columns.h"

namespace colmap_ext {

OrientedPoints ReadOrientedPoints(const std::filesystem::path& path) {
  const PlyData data = ReadPly(path);
  const ColumnReader rows(data, "vertex", path);
  OrientedPoints points(rows.NumRows());
  const auto positions = rows.Vectors(kPositionColumns);
  const auto normals = rows.Vectors(kNormalColumns);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position = positions[i];
    points[i].normal = normals[i];
  }
  if (rows.HasAll(kColorColumns)) {
    const auto colors = rows.Colors();
    for (std::size_t i = 0; i < points.size(); ++i) points[i].color = colors[i];
  }
  if (rows.Has("confidence")) {
    const auto& confidence = rows.Numbers("confidence");
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].confidence = static_cast<float>(confidence[i]);
    }
  }
  if (rows.Has("photo_index")) {
    const auto photo_index = rows.Integers("photo_index", -1, std::numeric_limits<int>::max());
    for (std::size_t i = 0; i < points.size(); ++i) points[i].photo_index = photo_index[i];
  }
  return points;
}

void WriteOrientedPoints(const OrientedPoints& points, const std::filesystem::path& path) {
  std::vector<Eigen::Vector3d> positions, normals;
  std::vector<Rgb8> colors;
  std::vector<double> confidence, photo_index;
  for (const OrientedPoint& point : points) {
    if (!point.position.allFinite() || !point.normal.allFinite() ||
        !std::isfinite(point.confidence)) {
      throw Error(path.string() + ": point " + std::to_string(positions.size()) + " is not finite");
    }
    positions.push_back(point.position);
    normals.push_back(point.normal);
    colors.push_back(point.color);
    confidence.push_back(point.confidence);
    photo_index.push_back(point.photo_index);
  }
  PlyElement rows;
  rows.name = "vertex";
  rows.count = points.size();
  AddVectors(kPositionColumns, positions, &rows);
  AddVectors(kNormalColumns, normals, &rows);
  AddColors(colors, &rows);
  AddNumbers("confidence", PlyType::kFloat32, std::move(confidence), &rows);
  AddNumbers("photo_index", PlyType::kInt32, std::move(photo_index), &rows);
  PlyData data;
  data.elements.push_back(std::move(rows));
  WritePly(data, path);
}

}  // namespace colmap_ext
