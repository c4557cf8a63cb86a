#include "colmap_ext/report/error_histogram.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

TEST(DrawErrorHistogram, BarsFollowTheErrors) {
  // All errors in the first bar: the left of the picture is blue, the right is not.
  const std::vector<double> small(1000, 0.0005);
  const cv::Mat picture = DrawErrorHistogram(small, 0.1, {0.0254, 0.0508}, {1000, 480});
  ASSERT_EQ(picture.size(), cv::Size(1000, 480));
  cv::Mat blue;
  cv::inRange(picture, cv::Scalar(165, 110, 40), cv::Scalar(180, 130, 60), blue);
  EXPECT_GT(cv::countNonZero(blue.colRange(50, 90)), 3000);
  EXPECT_EQ(cv::countNonZero(blue.colRange(200, 1000)), 0);
}

TEST(DrawErrorHistogram, WhatLiesBeyondIsInTheLastBar) {
  const cv::Mat picture =
      DrawErrorHistogram(std::vector<double>(10, 5.0), 0.1, {0.0254}, {1000, 480});
  const cv::Vec3b beyond = picture.at<cv::Vec3b>(300, 1000 - 56 - 10);
  EXPECT_GT(beyond[2], beyond[0] + 60) << "not red";
}

TEST(DrawErrorHistogram, NothingToDraw) {
  EXPECT_THROW(DrawErrorHistogram({}, 0.1, {}, {1000, 480}), Error);
  EXPECT_THROW(DrawErrorHistogram({0.1}, 0.1, {}, {10, 10}), Error);
}

}  // namespace
}  // namespace colmap_ext
