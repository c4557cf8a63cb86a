// What the flight daemon recorded when the camera took pictures: `captures.jsonl` beside them.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "colmap_ext/geom/geodesy.h"

namespace colmap_ext {

// One picture, as MAVLink's CAMERA_IMAGE_CAPTURED (263) and the receiver reported it.
struct CaptureRecord {
  int index = -1;        // of the camera; -1: unknown
  std::string time;      // ISO 8601, as written; empty: unknown
  GeoPosition position;  // height as in "height_m"
  std::optional<double> sigma_horizontal_m;
  std::optional<double> sigma_vertical_m;
  // Attitude of the camera, from the message's q (earth NED from camera forward, right, down): in
  // COLMAP's camera frame and ENU. Absent where the quaternion was not known.
  std::optional<Eigen::Quaterniond> cam_from_enu;
};

// A JSON object a line: {"type": "capture", "file": "a.jpg", "lat": deg, "lon": deg, "height_m": m}
// and, where known, "index", "time", "q": [w, x, y, z], "sigma_h_m", "sigma_v_m", "result" (0: the
// camera failed; skipped). Objects of another "type" and keys that are not named here are skipped;
// so is a last line without line end, which a crash may have cut. The same picture may be reported
// again with the same index (MAVLink repeats); the first report counts. Records by file name,
// relative to the folder of the journal. Throws Error naming file and line of anything else: no
// JSON object, a missing or wrong value, one file with two indices.
std::map<std::string, CaptureRecord> ReadCaptureJournal(const std::filesystem::path& path);

// The line for one picture, with its line end.
std::string CaptureJournalLine(const std::string& file, const CaptureRecord& record);

}  // namespace colmap_ext
