#include "colmap_ext/eval/error_colors.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

TEST(ErrorColors, BecomeLighterAndStopAtTheMaximum) {
  const auto colors = ErrorColors({0, 0.02, 0.04, 0.06, 0.08, 0.1, 5}, 0.1);
  ASSERT_EQ(colors.size(), 7u);
  const auto lightness = [](const Eigen::Vector3d& c) { return c.dot(Eigen::Vector3d(2, 7, 1)); };
  for (std::size_t i = 0; i + 2 < colors.size(); ++i) {
    EXPECT_LT(lightness(colors[i]), lightness(colors[i + 1]));
  }
  EXPECT_EQ(colors[5], colors[6]);
  EXPECT_LE(colors[6].maxCoeff(), 1.0);
}

}  // namespace
}  // namespace colmap_ext
