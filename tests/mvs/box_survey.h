// A survey that superpixel stereo is tried on, and how good its result is.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "mvs/analytic_scene.h"

namespace colmap_ext::test {

// A box of 3 x 3 x 2.5 m on a floor, photographed from an arc, with `num_points` SfM points.
inline AnalyticSurvey BoxSurvey(int num_points, int num_photos = 7) {
  AnalyticScene scene;
  scene.rectangles.push_back({{-15, -15, 0}, {30, 0, 0}, {0, 30, 0}, {120, 140, 130}, 1, 50});
  scene.rectangles.push_back({{-1.5, -1.5, 2.5}, {3, 0, 0}, {0, 3, 0}, {50, 60, 200}, 4, 50});
  scene.rectangles.push_back({{-1.5, -1.5, 0}, {3, 0, 0}, {0, 0, 2.5}, {190, 70, 60}, 7, 50});
  scene.rectangles.push_back({{1.5, -1.5, 0}, {0, 3, 0}, {0, 0, 2.5}, {60, 170, 80}, 10, 50});
  scene.rectangles.push_back({{-1.5, -1.5, 0}, {0, 3, 0}, {0, 0, 2.5}, {60, 170, 180}, 13, 50});
  std::vector<Rigid3d> poses;
  for (int i = 0; i < num_photos; ++i) {
    const double angle = 0.5 + 0.14 * (i - num_photos / 2);
    poses.push_back(LookAt({9 * std::sin(angle), -9 * std::cos(angle), 6}, {0, 0, 0.5}));
  }
  return Survey(scene, TestCamera(), poses, num_points);
}

struct Accuracy {
  double confident_share = 0;
  double median_error = 0;  // |Δz|/z over confident pixels
  double p90_error = 0;
  double all_mean = 0;  // over all pixels, each at most 1; unsupported ones count 1
};

inline Accuracy Measure(const std::vector<ViewMesh>& views, const std::vector<cv::Mat1d>& truth) {
  std::vector<double> errors;
  double pixels = 0;
  double sum = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewLookup lookup(views[i], TriangleIdMap(views[i]));
    for (int y = 0; y < truth[i].rows; y += 2) {
      for (int x = 0; x < truth[i].cols; x += 2) {
        if (!std::isfinite(truth[i](y, x))) continue;
        ++pixels;
        const auto t = static_cast<std::size_t>(lookup.triangle_at(y, x));
        if (views[i].supported[t] == 0) {
          sum += 1;
          continue;
        }
        const double depth = 1.0 / lookup.InverseDepth(static_cast<int>(t), {x + 0.5, y + 0.5});
        const double error = std::abs(depth / truth[i](y, x) - 1);
        sum += std::min(1.0, error);
        if (views[i].confidence[t] > 0.5) errors.push_back(error);
      }
    }
  }
  std::sort(errors.begin(), errors.end());
  if (errors.empty()) return {};
  return {static_cast<double>(errors.size()) / pixels, errors[errors.size() / 2],
          errors[errors.size() * 9 / 10], sum / pixels};
}

inline void ExpectSame(const SuperpixelStereoResult& a, const SuperpixelStereoResult& b) {
  EXPECT_EQ(a.neighbors, b.neighbors);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].photo_index, b.views[i].photo_index);
    EXPECT_EQ(a.views[i].inverse_depth, b.views[i].inverse_depth);
    EXPECT_EQ(a.views[i].confidence, b.views[i].confidence);
    EXPECT_EQ(a.views[i].supported, b.views[i].supported);
  }
}

}  // namespace colmap_ext::test
