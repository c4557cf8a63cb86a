#include "dense/point_dump.h"

#include "colmap_ext/util/files.h"
#include "scene/byte_reader.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kBytesPerPoint = 6 * sizeof(double) + 3 + sizeof(float) + sizeof(int);

}  // namespace

void WritePointDump(const OrientedPoints& points, const std::filesystem::path& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    WriteBytes(out, std::uint64_t{points.size()});
    for (const OrientedPoint& point : points) {
      for (int c = 0; c < 3; ++c) WriteBytes(out, point.position[c]);
      for (int c = 0; c < 3; ++c) WriteBytes(out, point.normal[c]);
      for (int c = 0; c < 3; ++c) WriteBytes(out, point.color[c]);
      WriteBytes(out, point.confidence);
      WriteBytes(out, point.photo_index);
    }
  });
}

void AppendPointDump(const std::filesystem::path& path, OrientedPoints* points) {
  ByteReader in(path);
  const std::size_t count = in.ReadCount(kBytesPerPoint, "points");
  points->reserve(points->size() + count);
  for (std::size_t i = 0; i < count; ++i) {
    OrientedPoint point;
    in.Take(point.position.data(), 3 * sizeof(double), "position");
    in.Take(point.normal.data(), 3 * sizeof(double), "normal");
    in.Take(point.color.data(), 3, "colour");
    point.confidence = in.Read<float>("confidence");
    point.photo_index = in.Read<int>("photo");
    points->push_back(point);
  }
  in.ExpectEnd();
}

}  // namespace colmap_ext
