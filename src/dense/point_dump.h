// Points handed from one process to another, every bit.
#pragma once

#include <filesystem>

#include "colmap_ext/scene/oriented_points.h"

namespace colmap_ext {

void WritePointDump(const OrientedPoints& points, const std::filesystem::path& path);
// Throws Error naming the file when it is damaged.
void AppendPointDump(const std::filesystem::path& path, OrientedPoints* points);

}  // namespace colmap_ext
