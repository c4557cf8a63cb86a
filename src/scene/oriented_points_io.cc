#include "colmap_ext/scene/oriented_points_io.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
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

namespace {

// A row of the file: the properties of kHeader, packed.
constexpr std::size_t kRowBytes = 6 * sizeof(double) + 3 + sizeof(float) + sizeof(std::int32_t);
constexpr const char* kHeader =
    "property double x\nproperty double y\nproperty double z\n"
    "property double nx\nproperty double ny\nproperty double nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property float confidence\nproperty int photo_index\nend_header\n";

void PackRow(const OrientedPoint& point, char* row) {
  const auto put = [&](const void* value, std::size_t bytes) {
    std::memcpy(row, value, bytes);
    row += bytes;
  };
  put(point.position.data(), 3 * sizeof(double));
  put(point.normal.data(), 3 * sizeof(double));
  put(point.color.data(), 3);
  put(&point.confidence, sizeof(float));
  const std::int32_t photo_index = point.photo_index;
  put(&photo_index, sizeof photo_index);
}

}  // namespace

void WriteOrientedPoints(const OrientedPoints& points, const std::filesystem::path& path) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].position.allFinite() || !points[i].normal.allFinite() ||
        !std::isfinite(points[i].confidence)) {
      throw Error(path.string() + ": point " + std::to_string(i) + " is not finite");
    }
  }
  // Row by row: millions of points would not fit into memory twice.
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size() << '\n'
        << kHeader;
    constexpr std::size_t kBlock = 65536;
    std::vector<char> rows(std::min(kBlock, points.size()) * kRowBytes);
    for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
      const std::size_t count = std::min(kBlock, points.size() - begin);
      for (std::size_t k = 0; k < count; ++k) {
        PackRow(points[begin + k], rows.data() + k * kRowBytes);
      }
      out.write(rows.data(), static_cast<std::streamsize>(count * kRowBytes));
    }
  });
}

}  // namespace colmap_ext
