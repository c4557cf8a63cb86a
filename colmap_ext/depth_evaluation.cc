#include "depth_evaluation.h"

#include <algorithm>
#include <iostream>
#include <optional>
#include <utility>
#include <vector>

#include "colmap_ext/eval/evaluate_depth.h"
#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Pairs of a map and the true one: the file, or every map of the folder.
std::vector<std::pair<fs::path, fs::path>> DepthPairs(const DepthMapPaths& paths) {
  if (!fs::is_directory(paths.depth)) {
    RequireFile(paths.depth, "depth map");
    const bool in_folder = fs::is_directory(paths.ground_truth);
    return {{paths.depth,
             in_folder ? paths.ground_truth / paths.depth.filename() : paths.ground_truth}};
  }
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(paths.depth)) {
    if (!entry.is_regular_file() || entry.path().extension() != ".bin") continue;
    const fs::path truth = paths.ground_truth / fs::relative(entry.path(), paths.depth);
    if (fs::is_regular_file(truth)) pairs.emplace_back(entry.path(), truth);
  }
  if (pairs.empty()) {
    throw Error(paths.depth.string() + ": no depth map (.bin) here has the name of one in " +
                paths.ground_truth.string());
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void PrintDepth(const DepthEvaluation& evaluation) {
  std::cout << "pixels with depth " << FormatNumber("%8.1f %%", 100 * evaluation.valid_share)
            << "\nmedian |dz|/z     " << FormatNumber("%8.3f %%", 100 * evaluation.median)
            << "\n90th percentile   " << FormatNumber("%8.3f %%", 100 * evaluation.percentile90)
            << "\nwithin 1 %        " << FormatNumber("%8.1f %%", 100 * evaluation.within_1_percent)
            << "\nwithin 5 %        " << FormatNumber("%8.1f %%", 100 * evaluation.within_5_percent)
            << "\nmean |dz|         " << FormatNumber("%8.1f mm\n", 1000 * evaluation.mean_error_m);
  if (evaluation.by_confidence.empty()) return;
  std::cout << "\n confidence      pixels      mean    median\n";
  for (const ConfidenceBin& bin : evaluation.by_confidence) {
    std::cout << FormatNumber("%4.1f", bin.low) << FormatNumber(" ... %.1f", bin.high)
              << FormatNumber("%12.0f", static_cast<double>(bin.pixels))
              << FormatNumber("%8.3f %%", 100 * bin.mean)
              << FormatNumber("%8.3f %%\n", 100 * bin.median);
  }
}

}  // namespace

void EvaluateDepthMaps(const DepthMapPaths& paths, const fs::path& output, const JobControl& job) {
  DepthEvaluator evaluator;
  const auto pairs = DepthPairs(paths);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    job.ThrowIfCancelled();
    const auto& [depth_path, truth_path] = pairs[i];
    std::optional<DenseMap> confidence;
    if (!paths.confidence.empty()) {
      const bool is_folder = fs::is_directory(paths.confidence);
      const fs::path name = fs::is_directory(paths.depth) ? fs::relative(depth_path, paths.depth)
                                                          : depth_path.filename();
      confidence = ReadDenseMap(is_folder ? paths.confidence / name : paths.confidence);
    }
    evaluator.Add(depth_path.string(), ReadDenseMap(depth_path), ReadDenseMap(truth_path),
                  confidence ? &*confidence : nullptr);
    job.Progress("evaluation", i + 1, pairs.size());
  }
  const DepthEvaluation evaluation = evaluator.Result();
  WriteFileAtomically(output, DepthEvaluationToJson(evaluation));
  PrintDepth(evaluation);
}

}  // namespace colmap_ext
