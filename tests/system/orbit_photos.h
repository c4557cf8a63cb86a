// Photos of the boxes as a person would take them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "colmap_ext/util/files.h"
#include "program.h"

namespace colmap_ext {

class OrbitPhotos : public ProgramTest {
 protected:
  // Renders `count` photos of an orbit around the boxes, from `first` on, with GPS in their EXIF.
  void RenderOrbit(const std::filesystem::path& folder, int first, int count) const {
    std::string poses;
    for (int i = first; i < first + count; ++i) {
      const double angle = 2.0 * M_PI * i / 24.0;
      char line[160];
      std::snprintf(line, sizeof line, "orbit_%02d.jpg %.4f %.4f 2.1 %.3f -32\n", i,
                    2.6 * std::sin(angle), 2.6 * std::cos(angle), angle * 180.0 / M_PI + 180.0);
      poses += line;
    }
    WriteFileAtomically(folder_ / "poses.txt", poses);
    const ChildProcessResult result = Run(
        {"scene_renderer", "--scene", "boxes", "--pose_list_path", (folder_ / "poses.txt").string(),
         "--output_path", (folder_ / "render").string(), "--Simulation.gps_noise_m", "0.01"});
    ASSERT_EQ(result.exit_code, 0) << result.output;
    std::filesystem::create_directories(folder);
    for (const std::string& name : ListPhotos(folder_ / "render" / "images")) {
      std::filesystem::rename(folder_ / "render" / "images" / name, folder / name);
    }
  }
};

}  // namespace colmap_ext
