#include "points_table.h"

#include <cstdio>
#include <string>

#include "colmap_ext/util/files.h"

namespace colmap_ext {

void WritePointsTable(const JudgedFlight& judged, const std::filesystem::path& path) {
  std::string text =
      "x,y,z,nx,ny,nz,views,pixel_mm,stereo_mm,scatter_mm,cloud_spacing_mm,predicted_mm,uncovered,"
      "uncovered_paper,true_mm,far_mm\n";
  for (const JudgedPoint& p : judged.points) {
    const Eigen::Vector3d& at = p.point.position;
    const Eigen::Vector3d& normal = p.point.normal;
    char line[320];
    std::snprintf(line, sizeof line,
                  "%.4f,%.4f,%.4f,%.3f,%.3f,%.3f,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%d,%.3f,%.3f\n",
                  at.x(), at.y(), at.z(), normal.x(), normal.y(), normal.z(), p.cues.num_views,
                  p.cues.pixel_mm, p.cues.stereo_mm, p.cues.scatter_mm, 1000 * p.cloud.spacing_m,
                  p.point.predicted_error_mm, p.point.coverage == CoverageClass::kUncovered,
                  p.paper == CoverageClass::kUncovered, 1000 * p.true_error_m,
                  1000 * p.distance_to_truth_m);
    text += line;
  }
  WriteFileAtomically(path, text);
}

}  // namespace colmap_ext
