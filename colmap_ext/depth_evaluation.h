// model_evaluator --depth_path: depth maps against true ones.
#pragma once

#include <filesystem>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Maps or folders of maps; names in folders correspond. `confidence` may be empty.
struct DepthMapPaths {
  std::filesystem::path depth;
  std::filesystem::path ground_truth;
  std::filesystem::path confidence;
};

// Compares, writes the JSON file `output` and prints a table. Throws Error when nothing
// corresponds, or a map cannot be read or has another size than its true one.
void EvaluateDepthMaps(const DepthMapPaths& paths, const std::filesystem::path& output,
                       const JobControl& job);

}  // namespace colmap_ext
