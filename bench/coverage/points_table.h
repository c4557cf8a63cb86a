// The judged points of a flight as a table, for other rules than ours.
#pragma once

#include <filesystem>

#include "judged.h"

namespace colmap_ext {

// CSV with a line of names: x, y, z (m), nx, ny, nz, views, pixel_mm, stereo_mm, scatter_mm,
// cloud_spacing_mm, predicted_mm, uncovered, uncovered_paper, true_mm, far_mm (to the truth that
// the point stands for). Replaces the file atomically.
void WritePointsTable(const JudgedFlight& judged, const std::filesystem::path& path);

}  // namespace colmap_ext
