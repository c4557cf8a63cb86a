#include "calibration.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/photometric.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

struct Sample {
  ConfidenceCues cues;
  PhotoCue photo;
  float error;
};

struct Quality {
  SuperpixelStereoOptions options;
  double area = 0;  // under the ROC curve
  double share = 0;
  double p90 = 0;
};

std::vector<Sample> CollectSamples(const Survey& survey, const SuperpixelStereoResult& result,
                                   const SuperpixelStereoOptions& options) {
  constexpr int kStep = 5;
  std::vector<ViewLookup> lookups;
  for (const ViewMesh& view : result.views) lookups.emplace_back(view, TriangleIdMap(view));
  const PhotometricStage stage(survey.photos, result.neighbors, options);
  std::vector<std::vector<Sample>> of_view(result.views.size());
  ParallelFor(of_view.size(), [&](std::size_t i) {
    const int view = static_cast<int>(i);
    const std::vector<ConfidenceCues> cues =
        EvaluateCues(result.views, lookups, result.neighbors[i], view, options);
    std::vector<PhotoCue> photo(cues.size());
    if (options.photometric) stage.EvaluateCues(result.views, lookups, view, {}, &photo);
    const ViewTruth& truth = survey.truth[i];
    for (int y = kStep / 2; y < truth.depth.rows; y += kStep) {
      for (int x = kStep / 2; x < truth.depth.cols; x += kStep) {
        const int t = lookups[i].triangle_at(y, x);
        if (truth.model(y, x) == 0 || t < 0) continue;
        const double inverse_depth = lookups[i].InverseDepth(t, {x + 0.5, y + 0.5});
        const double error = std::abs(1.0 / (inverse_depth * truth.depth(y, x)) - 1.0);
        of_view[i].push_back({cues[static_cast<std::size_t>(t)], photo[static_cast<std::size_t>(t)],
                              inverse_depth > 0 ? static_cast<float>(std::min(1.0, error)) : 1.0F});
      }
    }
  });
  std::vector<Sample> samples;
  for (const auto& part : of_view) samples.insert(samples.end(), part.begin(), part.end());
  return samples;
}

Quality Judge(const std::vector<Sample>& samples, const SuperpixelStereoOptions& options) {
  constexpr float kAccurate = 0.01F;
  Quality quality;
  quality.options = options;
  std::vector<std::pair<float, bool>> ranked;  // Γ, accurate
  std::vector<float> confident;
  double accurate = 0;
  for (const Sample& sample : samples) {
    const double confidence =
        ConfidenceScore(sample.cues, options) * PhotoConsistency(sample.photo, options);
    ranked.emplace_back(static_cast<float>(confidence), sample.error <= kAccurate);
    accurate += sample.error <= kAccurate;
    if (confidence > 0.5) confident.push_back(sample.error);
  }
  std::sort(ranked.begin(), ranked.end());
  double below = 0, area = 0;  // inaccurate samples so far
  for (const auto& [confidence, is_accurate] : ranked) {
    if (is_accurate) {
      area += below;
    } else {
      below += 1;
    }
  }
  quality.area = area / std::max(1.0, accurate * below);
  quality.share =
      static_cast<double>(confident.size()) / std::max(1.0, static_cast<double>(samples.size()));
  if (confident.empty()) return quality;
  const auto nth = confident.begin() + static_cast<std::ptrdiff_t>(confident.size() * 9 / 10);
  std::nth_element(confident.begin(), nth, confident.end());
  quality.p90 = *nth;
  return quality;
}

std::vector<SuperpixelStereoOptions> Grid(const SuperpixelStereoOptions& options) {
  std::vector<SuperpixelStereoOptions> grid;
  for (const double position : {1.0, 2.0, 4.0, 8.0}) {
    for (const double normal : {45.0, 90.0, 180.0}) {
      for (const double view : {0.05, 0.1, 0.2}) {
        for (const double photo : {0.2, 0.4, 0.8}) {
          SuperpixelStereoOptions tried = options;
          tried.sigma_position_px = position;
          tried.sigma_normal_deg = normal;
          tried.sigma_view = view;
          tried.sigma_photometric = photo;
          grid.push_back(tried);
        }
      }
    }
  }
  return grid;
}

void Report(const std::string& name, const Quality& quality, BenchReport* report) {
  report->Add(name + ": area under the ROC curve of confidence", quality.area, "");
  report->Add(name + ": pixels with confidence > 0.5", 100 * quality.share, "%");
  report->Add(name + ": 90th percentile there", 100 * quality.p90, "%");
  report->Add(name + ": sigma_position_px", quality.options.sigma_position_px, "px");
  report->Add(name + ": sigma_normal_deg", quality.options.sigma_normal_deg, "degrees");
  report->Add(name + ": sigma_view", quality.options.sigma_view, "");
  report->Add(name + ": sigma_photometric", quality.options.sigma_photometric, "");
}

}  // namespace

void ReportCalibration(const Survey& survey, const SuperpixelStereoResult& result,
                       const SuperpixelStereoOptions& options, BenchReport* report) {
  constexpr double kNearlyBest = 0.005;
  constexpr double kMaxP90 = 0.01;
  const std::vector<Sample> samples = CollectSamples(survey, result, options);
  const std::vector<SuperpixelStereoOptions> grid = Grid(options);
  std::vector<Quality> qualities(grid.size());
  ParallelFor(grid.size(), [&](std::size_t g) { qualities[g] = Judge(samples, grid[g]); });
  double largest = 0;
  for (const Quality& quality : qualities) largest = std::max(largest, quality.area);
  const Quality* best = nullptr;
  for (const Quality& quality : qualities) {
    if (quality.area < largest - kNearlyBest || quality.p90 > kMaxP90) continue;
    if (best == nullptr || quality.share > best->share) best = &quality;
  }
  Report("calibration, as set", Judge(samples, options), report);
  if (best != nullptr) Report("calibration, best", *best, report);
}

}  // namespace colmap_ext
