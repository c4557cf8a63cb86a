// Text files that give photos their positions when the photos do not.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

#include "colmap_ext/geom/geodesy.h"

namespace colmap_ext {

// Both kinds: a photo a line, words separated by blanks; a line with a comma is split at commas, so
// that names may hold blanks. Empty lines and lines that start with '#' are skipped. Throws Error
// naming the file and line of a wrong number of words, a bad number, or a photo named twice; and
// when no line names a photo.

// geo.txt: `name lon lat alt` in degrees and metres. As OpenDroneMap's, the file may start with a
// line that names the coordinate system, which must be EPSG:4326, and lines may go on with more
// columns (angles, accuracies), which are ignored.
std::map<std::string, GeoPosition> ReadGeoFile(const std::filesystem::path& path);

// Positions in local metres (ENU): `name x y z`.
std::map<std::string, Eigen::Vector3d> ReadPosePriorFile(const std::filesystem::path& path);
// Comes back to the last bit; written atomically, names with blanks by commas.
void WritePosePriorFile(const std::map<std::string, Eigen::Vector3d>& position_of_photo,
                        const std::filesystem::path& path);

}  // namespace colmap_ext
