// The coverage map as coverage.ply (all of it) and coverage.json (its summary).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/scene/coverage_map.h"

namespace colmap_ext {

// One vertex an iso-point: x y z nx ny nz (float64), red green blue (uncovered red, covered green,
// ignored blue), class (uchar, the number of CoverageClass), num_good_views (int),
// sample_spacing_m, best_projection_ratio, predicted_error_mm, score (float64). Header comments
// carry disk_area_m2, min_projection_ratio and target_error_mm. What is read is what was written,
// to the last bit; files without score or target_error_mm have 0 there. Errors name the file, and
// the point or property.
CoverageMap ReadCoverageMap(const std::filesystem::path& path);
void WriteCoverageMap(const CoverageMap& map, const std::filesystem::path& path);

// coverage.json: {"covered": n, "uncovered": n, "ignored": n, "covered_ratio": …, "area_m2": …,
// "predicted_error_mm": {"without": n, "median": …, "percentile90": …} (of the covered and
// uncovered points; "without": no photo sees them), "thresholds": {"min_projection_ratio":
// …, …}}. area_m2: the surface that has to be covered, that is covered and uncovered points times
// disk_area_m2. `thresholds`: those of the evaluation, by option name (min_projection_ratio is
// added from the map). Written atomically.
void WriteCoverageSummary(const CoverageMap& map, const std::map<std::string, double>& thresholds,
                          const std::filesystem::path& path);

}  // namespace colmap_ext
