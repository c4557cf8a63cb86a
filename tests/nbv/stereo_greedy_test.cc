#include "nbv/stereo_greedy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "nbv/hall_world.h"

namespace colmap_ext {
namespace {

// Random views that each see some of the points of a wall; who sees what is given.
class RandomPool : public ::testing::Test {
 protected:
  void Make(std::size_t num_views, unsigned seed) {
    world_ = HallWorld();
    world_.Uncover({Eigen::Vector3d(-12, -6, 0), Eigen::Vector3d(12, -4, 12)});
    options_ = {};
    options_.min_shared_features = 0;
    options_.min_relative_gain = 0;
    engine_.emplace(world_.mesh, VisibilityOptions());
    context_.emplace(SearchContext{options_, input_, *engine_, 625, 2, {}, {}});
    points_.emplace(world_.map, IndicesOfUncovered(world_.map), options_);
    pool_.clear();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> x(-10, 10), y(-16, -12), z(4, 12), size(1, 6);
    for (std::uint32_t v = 0; v < num_views; ++v) {
      PoolView view;
      view.position = {x(random), y(random), z(random)};
      view.place = v;
      const double radius = size(random);
      for (std::uint32_t i = 0; i < points_->size(); ++i) {
        const Eigen::Vector3d offset = points_->position(i) - view.position;
        if (std::hypot(offset.x(), offset.z()) < radius) view.seen.push_back(i);
      }
      pool_.push_back(view);
    }
  }

  StereoGreedy Greedy() const {
    return {*context_, pool_, *points_, FeatureOverlap(*context_), Eigen::Vector3d(0, -15, 8)};
  }

  // Stereo coverage of some views of the pool, from the start.
  double CoverageOf(const std::vector<std::size_t>& views) const {
    UncoveredPoints points = *points_;
    double coverage = 0;
    for (const std::size_t v : views) {
      for (const std::uint32_t i : pool_[v].seen) {
        if (points.IsPredictedCovered(i)) continue;
        coverage += points.StereoGain(i, pool_[v].position);
        points.AddGoodView(i, pool_[v].position);
      }
    }
    return coverage;
  }

  HallWorld world_;
  std::vector<PosedPhoto> photos_ = SouthLine();
  NextBestViewOptions options_;
  ViewPlanInput input_{world_.map, world_.mesh, photos_};
  std::optional<VisibilityEngine> engine_;
  std::optional<SearchContext> context_;
  std::optional<UncoveredPoints> points_;
  std::vector<PoolView> pool_;
};

TEST_F(RandomPool, TakesTheViewOfTheLargestGainEachTime) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    Make(60, seed);
    options_.num_views = 10;
    StereoGreedy greedy = Greedy();
    greedy.Run(StereoGreedy::Rule::kGain, {});
    ASSERT_EQ(greedy.views().size(), 10u);
    std::vector<std::size_t> chosen;
    for (const PoolView& view : greedy.views()) {
      double best = 0;
      const double before = CoverageOf(chosen);
      for (std::size_t v = 0; v < pool_.size(); ++v) {
        std::vector<std::size_t> more = chosen;
        more.push_back(v);
        best = std::max(best, CoverageOf(more) - before);
      }
      chosen.push_back(view.place);
      EXPECT_NEAR(CoverageOf(chosen) - before, best, 1e-4);  // gains are kept as float
    }
    EXPECT_NEAR(greedy.coverage(), CoverageOf(chosen), 1e-9);
  }
}

TEST_F(RandomPool, IsWithinTheBoundOfTheOptimum) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Make(14, seed);
    options_.num_views = 4;
    StereoGreedy greedy = Greedy();
    greedy.Run(StereoGreedy::Rule::kGain, {});
    double optimum = 0;
    for (std::size_t a = 0; a < 14; ++a) {
      for (std::size_t b = a + 1; b < 14; ++b) {
        for (std::size_t c = b + 1; c < 14; ++c) {
          for (std::size_t d = c + 1; d < 14; ++d) {
            optimum = std::max(optimum, CoverageOf({a, b, c, d}));
          }
        }
      }
    }
    EXPECT_GE(greedy.coverage(), (1 - std::exp(-1)) * optimum);
    EXPECT_GE(greedy.coverage(), 0.85 * optimum);  // in fact it is much nearer
  }
}

TEST_F(RandomPool, GainForTimeKeepsTheTourShorter) {
  Make(80, 2);
  options_.num_views = 12;
  StereoGreedy far = Greedy(), near = Greedy();
  far.Run(StereoGreedy::Rule::kGain, {});
  near.Run(StereoGreedy::Rule::kGainForTime, {});
  EXPECT_LT(near.tour().length_m(), far.tour().length_m());
  EXPECT_GT(near.coverage(), 0.7 * far.coverage());
}

TEST(StereoGain, CountsHalvesForFirstViewsAndPairs) {
  HallWorld world;
  world.AddPoint({0, -5, 6}, {0, -1, 0});
  world.map.points.back().coverage = CoverageClass::kUncovered;
  UncoveredPoints points(world.map, IndicesOfUncovered(world.map), {});
  ASSERT_EQ(points.size(), 1u);
  const auto from = [](double angle_deg) {
    return Eigen::Vector3d(10 * std::sin(DegToRad(angle_deg)),
                           -5 - 10 * std::cos(DegToRad(angle_deg)), 6);
  };
  EXPECT_EQ(points.StereoGain(0, from(0)), 0.5);
  points.AddGoodView(0, from(0));
  EXPECT_FALSE(points.IsPredictedCovered(0));
  EXPECT_EQ(points.StereoGain(0, from(1)), 0);      // a repetition
  EXPECT_EQ(points.StereoGain(0, from(10)), 0.5);   // a pair
  EXPECT_EQ(points.StereoGain(0, from(45)), 0.25);  // too far off to be one
  points.AddGoodView(0, from(45));
  EXPECT_FALSE(points.IsPredictedCovered(0));
  EXPECT_EQ(points.StereoGain(0, from(60)), 0.5);  // with the second
  points.AddGoodView(0, from(60));
  EXPECT_TRUE(points.IsPredictedCovered(0));
  EXPECT_EQ(points.StereoGain(0, from(20)), 0);
}

}  // namespace
}  // namespace colmap_ext
