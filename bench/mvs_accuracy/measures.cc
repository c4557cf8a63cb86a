#include "measures.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/mvs/depth_map.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

struct PixelError {
  float error;
  float confidence;
  bool supported;
};

std::vector<PixelError> CollectErrors(const ViewMesh& view, const ViewTruth& truth, Pixels pixels,
                                      int step) {
  const ViewMaps maps = RasterizeView(view, 0.0);
  std::vector<PixelError> errors;
  for (int y = step / 2; y < truth.depth.rows; y += step) {
    for (int x = step / 2; x < truth.depth.cols; x += step) {
      const float z = truth.depth(y, x);
      if (!(z > 0) || (pixels == Pixels::kModel && truth.model(y, x) == 0)) continue;
      const float depth = maps.depth.At(y, x);
      PixelError pixel{1.0F, 0.0F, depth > 0};
      if (depth > 0) {
        pixel.error = std::min(1.0F, std::abs(depth - z) / z);
        pixel.confidence = maps.confidence.At(y, x);
      }
      errors.push_back(pixel);
    }
  }
  return errors;
}

// `share`-quantile of the errors.
double Quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

void FillDeciles(std::vector<PixelError> witnessed, AccuracyFigures* figures) {
  std::stable_sort(
      witnessed.begin(), witnessed.end(),
      [](const PixelError& a, const PixelError& b) { return a.confidence < b.confidence; });
  for (std::size_t d = 0; d < 10; ++d) {
    const std::size_t begin = d * witnessed.size() / 10;
    const std::size_t end = (d + 1) * witnessed.size() / 10;
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += witnessed[i].error;
    if (end == begin) continue;
    figures->decile_error[d] = sum / static_cast<double>(end - begin);
    figures->decile_confidence[d] = witnessed[end - 1].confidence;
    if (d > 0 && figures->decile_error[d] > figures->decile_error[d - 1]) {
      ++figures->rising_deciles;
    }
  }
}

// For each pixel the largest ratio - 1 of depths to its right and lower neighbour, where `depth` is
// positive in both and the nearer one is on the model.
cv::Mat1f DepthJumps(const cv::Mat1f& depth, const cv::Mat1b& model) {
  cv::Mat1f jumps(depth.size(), 0.0F);
  for (int y = 0; y + 1 < depth.rows; ++y) {
    for (int x = 0; x + 1 < depth.cols; ++x) {
      const float here = depth(y, x);
      if (!(here > 0)) continue;
      for (const cv::Point other : {cv::Point(x + 1, y), cv::Point(x, y + 1)}) {
        const float there = depth(other);
        if (!(there > 0)) continue;
        if ((here < there ? model(y, x) : model(other)) == 0) continue;
        jumps(y, x) = std::max(jumps(y, x), std::max(here, there) / std::min(here, there) - 1.0F);
      }
    }
  }
  return jumps;
}

float LargestNear(const cv::Mat1f& jumps, int x, int y) {
  constexpr int kRadius = 2;
  float largest = 0;
  for (int v = std::max(0, y - kRadius); v <= std::min(jumps.rows - 1, y + kRadius); ++v) {
    for (int u = std::max(0, x - kRadius); u <= std::min(jumps.cols - 1, x + kRadius); ++u) {
      largest = std::max(largest, jumps(v, u));
    }
  }
  return largest;
}

// Pixels with a jump of more than kJump, and those of them for which `others` has one of more than
// half as much (`relative`), or of kJump / 2, nearby.
struct Matches {
  double all = 0, matched = 0;
};
Matches CountMatches(const cv::Mat1f& jumps, const cv::Mat1f& others, bool relative) {
  constexpr float kJump = 0.05F;
  Matches matches;
  for (int y = 0; y < jumps.rows; ++y) {
    for (int x = 0; x < jumps.cols; ++x) {
      if (!(jumps(y, x) > kJump)) continue;
      matches.all += 1;
      const float wanted = 0.5F * (relative ? jumps(y, x) : kJump);
      matches.matched += LargestNear(others, x, y) > wanted;
    }
  }
  return matches;
}

}  // namespace

AccuracyFigures MeasureAccuracy(const std::vector<ViewMesh>& views,
                                const std::vector<ViewTruth>& truth, Pixels pixels, int step) {
  std::vector<std::vector<PixelError>> errors_of_view(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    errors_of_view[i] = CollectErrors(views[i], truth[i], pixels, step);
  });
  AccuracyFigures figures;
  std::vector<float> confident, supported;
  std::vector<PixelError> witnessed;
  double count = 0, accurate = 0, wrong = 0;
  for (const std::vector<PixelError>& errors : errors_of_view) {
    for (const PixelError& pixel : errors) {
      count += 1;
      if (pixel.supported) supported.push_back(pixel.error);
      if (pixel.confidence > 0) witnessed.push_back(pixel);
      if (!(pixel.confidence > 0.5F)) continue;
      confident.push_back(pixel.error);
      wrong += pixel.error > 0.05F;
      accurate += pixel.error <= 0.01F;
    }
  }
  if (count == 0) return figures;
  figures.share_confident = static_cast<double>(confident.size()) / count;
  figures.share_supported = static_cast<double>(supported.size()) / count;
  figures.share_accurate = accurate / count;
  figures.share_wrong = confident.empty() ? 0 : wrong / static_cast<double>(confident.size());
  figures.median = Quantile(confident, 0.5);
  figures.p90 = Quantile(confident, 0.9);
  figures.median_supported = Quantile(supported, 0.5);
  figures.p90_supported = Quantile(supported, 0.9);
  FillDeciles(std::move(witnessed), &figures);
  return figures;
}

EdgeFigures MeasureDepthEdges(const std::vector<ViewMesh>& views,
                              const std::vector<ViewTruth>& truth) {
  std::vector<Matches> recalled(views.size()), confirmed(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    ViewMaps maps = RasterizeView(views[i], 0.0);
    const cv::Mat1f depth(maps.depth.height, maps.depth.width, maps.depth.data.data());
    const cv::Mat1f true_jumps = DepthJumps(truth[i].depth, truth[i].model);
    const cv::Mat1f jumps = DepthJumps(depth, truth[i].model);
    recalled[i] = CountMatches(true_jumps, jumps, true);
    confirmed[i] = CountMatches(jumps, true_jumps, false);
  });
  Matches recall, precision;
  for (std::size_t i = 0; i < views.size(); ++i) {
    recall.all += recalled[i].all;
    recall.matched += recalled[i].matched;
    precision.all += confirmed[i].all;
    precision.matched += confirmed[i].matched;
  }
  return {recall.matched / std::max(1.0, recall.all),
          precision.matched / std::max(1.0, precision.all)};
}

}  // namespace colmap_ext
