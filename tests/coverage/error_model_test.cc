#include "colmap_ext/coverage/error_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

TEST(TriangulationError, IsTheTraceOfTheInverseInformation) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 50; ++trial) {
    ViewOfPoint views[2];
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (ViewOfPoint& view : views) {
      view.direction = Eigen::Vector3d(unit(random), unit(random), 1.5).normalized();
      view.projection_ratio = 600 + 500 * unit(random);
      const double squared_s = 0.25 / view.projection_ratio;
      information +=
          (Eigen::Matrix3d::Identity() - view.direction * view.direction.transpose()) / squared_s;
    }
    EXPECT_NEAR(TriangulationError(views[0], views[1], 0.5),
                std::sqrt(information.inverse().trace()), 1e-9);
  }
}

TEST(PredictedError, TakesTheBestUsablePair) {
  const auto view = [](double angle_deg, double ratio) {
    return ViewOfPoint{{std::sin(DegToRad(angle_deg)), 0, std::cos(DegToRad(angle_deg))}, ratio};
  };
  const double max_angle = DegToRad(30);
  EXPECT_EQ(PredictedError({}, 0.5, max_angle), -1);
  EXPECT_EQ(PredictedError({view(0, 625), view(45, 625)}, 0.5, max_angle), -1);
  const double at_10 = PredictedError({view(0, 625), view(10, 625)}, 0.5, max_angle);
  EXPECT_NEAR(at_10, 0.02 * std::sqrt(2.0) / std::sin(DegToRad(10)), 0.01 * at_10);
  EXPECT_LT(PredictedError({view(0, 625), view(10, 625), view(20, 625)}, 0.5, max_angle), at_10);
  EXPECT_GT(PredictedError({view(0, 100), view(10, 100)}, 0.5, max_angle), at_10);
}

ViewOfPoint View(double angle_deg, double ratio) {
  return {{std::sin(DegToRad(angle_deg)), 0, std::cos(DegToRad(angle_deg))}, ratio};
}

ErrorCues Cues(const std::vector<ViewOfPoint>& views, double spacing_m) {
  return CuesOf(views, spacing_m, DegToRad(40));
}

TEST(CuesOf, AreWhatThePhotosSee) {
  const ErrorCues cues = Cues({View(0, 2500), View(10, 625), View(90, 100)}, 0.07);
  EXPECT_EQ(cues.num_views, 3);
  EXPECT_NEAR(cues.pixel_mm, 20, 1e-9);
  EXPECT_NEAR(cues.scatter_mm, 70, 1e-9);
  EXPECT_NEAR(cues.stereo_mm, 1000 * TriangulationError(View(0, 2500), View(10, 625), 1), 1e-9);
  EXPECT_EQ(Cues({View(0, 2500)}, 0).stereo_mm, -1);
  EXPECT_EQ(Cues({}, 0).num_views, 0);
}

TEST(PredictErrorMm, FollowsItsEquation) {
  const ErrorModel model;
  const ErrorCues cues{.num_views = 4, .pixel_mm = 20, .stereo_mm = 160, .scatter_mm = 100};
  EXPECT_NEAR(PredictErrorMm(cues, model),
              20 * model.scale * std::pow(8, model.stereo_exponent) *
                  std::pow(5, model.scatter_exponent) * std::pow(5, -model.views_exponent),
              1e-9);
}

TEST(PredictErrorMm, ASceneTenTimesAsLargeErrsTenTimesAsMuch) {
  const ErrorModel model;
  const ErrorCues small{.num_views = 3, .pixel_mm = 3, .stereo_mm = 30, .scatter_mm = 12};
  const ErrorCues large{.num_views = 3, .pixel_mm = 30, .stereo_mm = 300, .scatter_mm = 120};
  EXPECT_NEAR(PredictErrorMm(large, model), 10 * PredictErrorMm(small, model), 1e-9);
}

TEST(PredictErrorMm, WhatIsNotKnownIsTheWorstOrTheTypical) {
  const ErrorModel model;
  EXPECT_EQ(PredictErrorMm(ErrorCues(), model), -1);
  const ErrorCues one_view{.num_views = 1, .pixel_mm = 20, .stereo_mm = -1, .scatter_mm = 100};
  const ErrorCues bad_pair{.num_views = 1, .pixel_mm = 20, .stereo_mm = 1e6, .scatter_mm = 100};
  EXPECT_EQ(PredictErrorMm(one_view, model), PredictErrorMm(bad_pair, model));
  const ErrorCues unknown{.num_views = 3, .pixel_mm = 20, .stereo_mm = 90, .scatter_mm = 0};
  ErrorCues typical = unknown;
  typical.scatter_mm = 20 * model.typical_scatter_px;
  EXPECT_NEAR(PredictErrorMm(unknown, model), PredictErrorMm(typical, model), 1e-9);
}

// Views may only help, whatever they are; so may points nearer to the surface.
TEST(PredictErrorMm, AViewMoreNeverMakesItWorse) {
  const ErrorModel model;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<ViewOfPoint> views;
    const double spacing = std::exp(3 * unit(random) - 3);
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 8; ++i) {
      views.push_back({Eigen::Vector3d(unit(random), unit(random), 1).normalized(),
                       std::exp(7 + 3 * unit(random))});
      const double after = PredictErrorMm(Cues(views, spacing), model);
      EXPECT_LE(after, before * (1 + 1e-12));
      EXPECT_LE(PredictErrorMm(Cues(views, 0.5 * spacing), model), after * (1 + 1e-12));
      before = after;
    }
  }
}

TEST(ProbabilityWithin, IsOneHalfAtThePredictionAndGrowsWithTheTarget) {
  const ErrorModel model;
  EXPECT_EQ(ProbabilityWithin(50, 50, 0, model), 0.5);
  EXPECT_GT(ProbabilityWithin(100, 50, 0, model), 0.7);
  EXPECT_LT(ProbabilityWithin(25, 50, 0, model), 0.3);
  EXPECT_EQ(ProbabilityWithin(50, -1, 0, model), 0);
  EXPECT_EQ(ProbabilityWithin(50, 50, 0.4, model), 0.3);
  EXPECT_EQ(ProbabilityWithin(1e9, 1, 1, model), 0);
}

TEST(FailureProbability, FollowsItsEquation) {
  const ErrorModel model;
  const CueLogs around{std::log(8), std::log(5), std::log(4)};
  const double odds = std::exp(model.failure_constant) * std::pow(8, model.failure_stereo) *
                      std::pow(5, model.failure_scatter) * std::pow(4, -model.failure_views);
  EXPECT_NEAR(FailureProbability(around, model), odds / (1 + odds), 1e-12);
}

TEST(FailureProbability, GrowsWithWeakStereoAndFallsWithViews) {
  const ErrorModel model;
  const CueLogs around{1.5, 1.5, 1.5};
  const double failure = FailureProbability(around, model);
  EXPECT_GT(FailureProbability({2.5, 1.5, 1.5}, model), failure);
  EXPECT_GT(FailureProbability({1.5, 2.5, 1.5}, model), failure);
  EXPECT_LT(FailureProbability({1.5, 1.5, 2.5}, model), failure);
}

TEST(MeanLogsAround, TakesTheNearestAndItself) {
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {1, 0, 0}, {2.5, 0, 0}, {100, 0, 0}};
  const std::vector<CueLogs> logs = {{3, 0, 6}, {6, 3, 0}, {9, 6, 3}, {30, 30, 30}};
  const std::vector<CueLogs> means = MeanLogsAround(line, logs, 3);
  EXPECT_NEAR(means[0].stereo, 6, 1e-12);
  EXPECT_NEAR(means[0].scatter, 3, 1e-12);
  EXPECT_NEAR(means[0].views, 3, 1e-12);
  EXPECT_NEAR(means[3].stereo, 15, 1e-12);
  // One neighbour is the place itself; more than there are is all of them.
  EXPECT_NEAR(MeanLogsAround(line, logs, 1)[2].stereo, 9, 1e-12);
  EXPECT_NEAR(MeanLogsAround(line, logs, 50)[1].stereo, 12, 1e-12);
  EXPECT_TRUE(MeanLogsAround({}, {}, 5).empty());
}

TEST(ErrorModel, WrongConstantsAreNamed) {
  const auto complaint = [](double ErrorModel::*constant, double value) {
    ErrorModel model;
    model.*constant = value;
    return model.Check();
  };
  EXPECT_EQ(ErrorModel().Check(), "");
  EXPECT_THAT(complaint(&ErrorModel::scale, 0), ::testing::HasSubstr("ErrorModel.scale"));
  EXPECT_THAT(complaint(&ErrorModel::scatter_exponent, 0.9), ::testing::HasSubstr("at most 1"));
  EXPECT_THAT(complaint(&ErrorModel::views_exponent, -1), ::testing::HasSubstr("views_exponent"));
  EXPECT_THAT(complaint(&ErrorModel::steepness, 0), ::testing::HasSubstr("steepness"));
  EXPECT_THAT(complaint(&ErrorModel::failure_views, -1), ::testing::HasSubstr("failure_views"));
  EXPECT_THAT(complaint(&ErrorModel::max_angle_deg, 200), ::testing::HasSubstr("max_angle_deg"));
  EXPECT_THAT(complaint(&ErrorModel::max_stereo_px, 0), ::testing::HasSubstr("max_stereo_px"));
  EXPECT_THAT(complaint(&ErrorModel::max_scatter_px, 0.05), ::testing::HasSubstr("at least"));
}

}  // namespace
}  // namespace colmap_ext
