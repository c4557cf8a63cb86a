#include "colmap_ext/dense/depth_estimate.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

struct Hypothesis {
  float inverse_depth;
  float per_pixel;
};

struct Group {
  float inverse_depth = 0;
  int count = 0;
};

Group LargestGroup(const Hypothesis* all, int n, float agreement_px) {
  Group best;
  float best_weight = 0;
  for (int k = 0; k < n; ++k) {
    float sum = 0, weight_sum = 0;
    int count = 0;
    for (int m = 0; m < n; ++m) {
      const float tolerance = agreement_px * std::max(all[k].per_pixel, all[m].per_pixel);
      if (std::abs(all[k].inverse_depth - all[m].inverse_depth) > tolerance) continue;
      const float weight = 1 / (all[m].per_pixel * all[m].per_pixel);
      sum += weight * all[m].inverse_depth;
      weight_sum += weight;
      ++count;
    }
    if (count > best.count || (count == best.count && weight_sum > best_weight)) {
      best = {sum / weight_sum, count};
      best_weight = weight_sum;
    }
  }
  if (best.count == 1 && n > 1) return {};
  return best;
}

StereoView AtLevel(const StereoView& view, int level) {
  if (level == 0) return view;
  StereoView scaled = view;
  const int width = std::max(1, view.camera.width >> level);
  const int height = std::max(1, view.camera.height >> level);
  scaled.camera = ScaleTo(view.camera, width, height);
  cv::resize(view.gray, scaled.gray, cv::Size(width, height), 0, 0, cv::INTER_AREA);
  return scaled;
}

// Weighted values one level down: sums over 2 x 2.
void Pull(cv::Mat* value, cv::Mat* weight) {
  const cv::Size size((value->cols + 1) / 2, (value->rows + 1) / 2);
  cv::Mat product = value->mul(*weight), small_weight, small_product;
  cv::resize(product, small_product, size, 0, 0, cv::INTER_AREA);
  cv::resize(*weight, small_weight, size, 0, 0, cv::INTER_AREA);
  cv::Mat small_value = cv::Mat::zeros(size, CV_32F);
  cv::divide(small_product, cv::max(small_weight, 1e-12F), small_value);
  *value = small_value;
  cv::Mat is_known = small_weight > 0;
  small_weight.setTo(1, is_known);
  *weight = small_weight;
}

}  // namespace

MergedDepth MergePairs(const std::vector<PairDepth>& pairs, double agreement_px) {
  const cv::Size size = pairs.at(0).inverse_depth.size();
  MergedDepth merged{cv::Mat::zeros(size, CV_32F), cv::Mat::zeros(size, CV_8U)};
  ParallelFor(size.height, [&](int y) {
    std::vector<Hypothesis> all(pairs.size());
    for (int x = 0; x < size.width; ++x) {
      int n = 0;
      for (const PairDepth& pair : pairs) {
        const float inverse_depth = pair.inverse_depth.at<float>(y, x);
        if (inverse_depth > 0) {
          all[static_cast<std::size_t>(n++)] = {inverse_depth, pair.per_pixel.at<float>(y, x)};
        }
      }
      const Group group = LargestGroup(all.data(), n, static_cast<float>(agreement_px));
      merged.inverse_depth.at<float>(y, x) = group.inverse_depth;
      merged.pairs.at<unsigned char>(y, x) = static_cast<unsigned char>(group.count);
    }
  });
  return merged;
}

cv::Mat FillHoles(const MergedDepth& depth, float fallback) {
  std::vector<cv::Mat> values, weights;
  cv::Mat value, weight;
  cv::medianBlur(depth.inverse_depth, value, 5);  // holes count as 0: crumbs go
  value.copyTo(weight);
  weight.setTo(1, value > 0);
  while (true) {
    values.push_back(value.clone());
    weights.push_back(weight.clone());
    if (value.cols <= 1 && value.rows <= 1) break;
    Pull(&value, &weight);
  }
  if (!(weights.back().at<float>(0, 0) > 0)) values.back().setTo(fallback);
  for (std::size_t level = values.size() - 1; level-- > 0;) {
    cv::Mat coarse;
    cv::resize(values[level + 1], coarse, values[level].size(), 0, 0, cv::INTER_LINEAR);
    coarse.copyTo(values[level], weights[level] == 0);
  }
  return values[0];
}

MergedDepth EstimateDepth(const StereoView& reference, const std::vector<StereoView>& partners,
                          const DepthRange& range, const DenseStereoOptions& options) {
  MergedDepth merged;
  if (partners.empty() || !range.IsKnown()) {
    throw Error("depth of a photo needs a partner and a range of depths");
  }
  int coarsest = 0;
  while ((reference.camera.width >> (coarsest + 1)) >= options.coarse_width_px) ++coarsest;
  StereoSearch search;
  search.range = range;
  for (int level = coarsest; level >= 0; --level) {
    const StereoView scaled = AtLevel(reference, level);
    std::vector<PairDepth> pairs;
    for (const StereoView& partner : partners) {
      pairs.push_back(MatchPair(scaled, AtLevel(partner, level), search, options));
    }
    merged = MergePairs(pairs, options.agreement_px);
    if (level > 0) {
      search.inverse_depth = FillHoles(merged, static_cast<float>(1 / range.max));
    }
  }
  return merged;
}

}  // namespace colmap_ext
