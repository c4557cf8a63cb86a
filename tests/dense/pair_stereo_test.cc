#include "colmap_ext/dense/pair_stereo.h"

#include <gtest/gtest.h>

#include "colmap_ext/dense/depth_estimate.h"
#include "dense/wall_survey.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

using test::DepthScore;
using test::LookingNorthFrom;
using test::Score;
using test::ViewFrom;

const DepthRange kRange{4, 20};

cv::Mat1d TruthFrom(const Rigid3d& cam_from_world) {
  return test::Photograph(test::WallScene(), test::SmallCamera(), cam_from_world, "t.png").depth;
}

TEST(MatchPair, FindsTheDepthForEveryDirectionOfTheBaseline) {
  struct Case {
    const char* name;
    Rigid3d partner;
    double valid, good;
  };
  const std::vector<Case> cases = {{"right", LookingNorthFrom(0.8, 0, 0), 0.8, 0.7},
                                   {"left", LookingNorthFrom(-0.8, 0, 0), 0.8, 0.7},
                                   {"up", LookingNorthFrom(0, 0, 0.8), 0.75, 0.7},
                                   {"down and back", LookingNorthFrom(0, -0.3, -0.8), 0.75, 0.7},
                                   {"turned", CamFromWorld({0.9, 0, 0}, {-0.08, 0.03}), 0.7, 0.7},
                                   // Near the epipole there is no parallax.
                                   {"forward", LookingNorthFrom(0.05, 2, 0), 0.15, 0.5}};
  const Rigid3d pose = LookingNorthFrom(0, 0, 0);
  const StereoView reference = ViewFrom(pose);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const PairDepth depth =
        MatchPair(reference, ViewFrom(c.partner), {kRange, cv::Mat()}, DenseStereoOptions());
    const DepthScore score = Score(depth.inverse_depth, TruthFrom(pose));
    EXPECT_GT(score.valid, c.valid);
    EXPECT_GT(score.good, c.good);
  }
}

TEST(MatchPair, MeansTheSameWhateverThePrior) {
  const Rigid3d pose = LookingNorthFrom(0, 0, 0);
  const StereoView reference = ViewFrom(pose), partner = ViewFrom(LookingNorthFrom(0.8, 0, 0));
  DenseStereoOptions options;
  // One pair of small photos: 1 % of the depth is 0.18 px of parallax here. The wall is 17 px of
  // parallax away at 10 m: priors that are off by 5 px and slanted wrongly.
  for (const double tilt : {-0.015, 0.0, 0.015}) {
    cv::Mat prior(40, 60, CV_32F);
    for (int y = 0; y < prior.rows; ++y) {
      for (int x = 0; x < prior.cols; ++x) {
        prior.at<float>(y, x) = static_cast<float>(0.1 + 0.015 + tilt * (x - 30) / 30.0);
      }
    }
    const PairDepth depth = MatchPair(reference, partner, {kRange, prior}, options);
    const DepthScore score = Score(depth.inverse_depth, TruthFrom(pose));
    EXPECT_GT(score.valid, 0.8) << tilt;
    EXPECT_GT(score.good, 0.7) << tilt;
    EXPECT_LT(score.median_error, 0.008) << tilt;
  }
}

TEST(MatchPair, SaysHowMuchAPixelIsWorth) {
  const Rigid3d pose = LookingNorthFrom(0, 0, 0);
  const PairDepth depth = MatchPair(ViewFrom(pose), ViewFrom(LookingNorthFrom(0.8, 0, 0)),
                                    {kRange, cv::Mat()}, DenseStereoOptions());
  // Sideways: d(1/z) = 1 / (f b).
  EXPECT_NEAR(depth.per_pixel.at<float>(80, 120), 1 / (220 * 0.8), 0.02 / (220 * 0.8));
}

TEST(MatchPair, LeavesHolesWhereThePartnerSeesNothing) {
  const Rigid3d pose = LookingNorthFrom(0, 0, 0);
  const StereoView reference = ViewFrom(pose);
  StereoView away = ViewFrom(CamFromWorld({0.8, 0, 0}, {3.0, 0}));
  const PairDepth depth = MatchPair(reference, away, {kRange, cv::Mat()}, DenseStereoOptions());
  EXPECT_LT(Score(depth.inverse_depth, TruthFrom(pose)).valid, 0.02);
  ExpectError(
      [&] {
        MatchPair(reference, reference, {kRange, cv::Mat()}, DenseStereoOptions());
      },
      {"same place"});
}

TEST(SampleSmooth, InterpolatesOnSurfacesAndNotAcrossEdgesOrHoles) {
  cv::Mat map = (cv::Mat_<float>(2, 3) << 1.0F, 1.01F, 5.0F, 1.0F, 1.01F, 0.0F);
  EXPECT_NEAR(SampleSmooth(map, 0.5, 0.5, 0.02), 1.005, 1e-6);
  EXPECT_EQ(SampleSmooth(map, 1.4, 0.0, 0.02), 1.01F);
  EXPECT_EQ(SampleSmooth(map, 1.6, 0.0, 0.02), 5.0F);
  EXPECT_EQ(SampleSmooth(map, 1.9, 0.9, 0.02), 0.0F);
  EXPECT_EQ(SampleSmooth(map, 7, 0, 0.02), 0.0F);
}

PairDepth Uniform(float inverse_depth, float per_pixel) {
  return {cv::Mat(2, 2, CV_32F, cv::Scalar(inverse_depth)),
          cv::Mat(2, 2, CV_32F, cv::Scalar(per_pixel))};
}

TEST(MergePairs, TakesTheLargestGroupAndTrustsLongBaselines) {
  const MergedDepth merged = MergePairs(
      {Uniform(0.100F, 0.004F), Uniform(0.102F, 0.002F), Uniform(0.3F, 0.002F), Uniform(0, 0)}, 1);
  EXPECT_EQ(merged.pairs.at<unsigned char>(1, 1), 2);
  EXPECT_NEAR(merged.inverse_depth.at<float>(1, 1), (0.1 * 1 + 0.102 * 4) / 5, 1e-6);
  const MergedDepth quarrel = MergePairs({Uniform(0.1F, 0.002F), Uniform(0.3F, 0.002F)}, 1);
  EXPECT_EQ(quarrel.pairs.at<unsigned char>(0, 0), 0);
  EXPECT_EQ(quarrel.inverse_depth.at<float>(0, 0), 0);
  const MergedDepth alone = MergePairs({Uniform(0.1F, 0.002F), Uniform(0, 0)}, 1);
  EXPECT_EQ(alone.pairs.at<unsigned char>(0, 0), 1);
}

TEST(FillHoles, KeepsWhatIsThereAndContinuesIt) {
  MergedDepth depth{cv::Mat(40, 60, CV_32F, cv::Scalar(0.2)), cv::Mat::ones(40, 60, CV_8U)};
  depth.inverse_depth(cv::Rect(20, 10, 20, 20)).setTo(0);
  const cv::Mat filled = FillHoles(depth, 0.5F);
  for (const cv::Point p : {cv::Point(30, 20), cv::Point(2, 2), cv::Point(21, 11)}) {
    EXPECT_NEAR(filled.at<float>(p), 0.2, 1e-5);
  }
  depth.inverse_depth.setTo(0);
  EXPECT_EQ(FillHoles(depth, 0.5F).at<float>(7, 7), 0.5F);
}

TEST(EstimateDepth, IsExactAndCompleteFromCoarseToFine) {
  const test::AnalyticSurvey survey = test::WallSurvey(4);
  DenseStereoOptions options;
  options.coarse_width_px = 64;
  options.residual_px = 8;
  std::vector<StereoView> partners;
  for (const std::size_t i : {0U, 2U, 3U}) {
    partners.push_back(test::ViewOf(survey.photos.photos[i]));
  }
  const MergedDepth depth =
      EstimateDepth(test::ViewOf(survey.photos.photos[1]), partners, kRange, options);
  const DepthScore score = Score(depth.inverse_depth, survey.depth[1]);
  EXPECT_GT(score.valid, 0.85);
  EXPECT_GT(score.good, 0.85);
  EXPECT_LT(score.median_error, 0.006);
  ExpectError([&] { EstimateDepth(partners[0], {}, kRange, options); }, {"partner"});
}

}  // namespace
}  // namespace colmap_ext
