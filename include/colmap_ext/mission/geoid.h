// Height of the geoid over the ellipsoid: what separates heights above sea level from GPS heights.
#pragma once

#include <filesystem>
#include <optional>

namespace colmap_ext {

// EGM96 as PROJ's package of data has it (Debian: proj-data, which OpenCV's picture readers bring).
inline constexpr const char* kEgm96Grid = "/usr/share/proj/egm96_15.gtx";

// Undulation N (metres) of the grid at a place: ellipsoidal height = height above sea level + N.
// Bilinear in the 15' grid: 0.04 m RMS and 1.2 m at most from EGM96 itself. `grid`: a file in
// NOAA's GTX format that covers the whole Earth. nullopt when there is no such file; throws Error
// naming the file when it is there but wrong.
std::optional<double> GeoidUndulation(double lat_deg, double lon_deg,
                                      const std::filesystem::path& grid = kEgm96Grid);

}  // namespace colmap_ext
