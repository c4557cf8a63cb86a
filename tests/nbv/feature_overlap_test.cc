#include "nbv/feature_overlap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "nbv/hall_world.h"

namespace colmap_ext {
namespace {

// Sparse points on the hall, seen by the photos of the south line that have them in the image.
class Overlap : public ::testing::Test {
 protected:
  Overlap() {
    for (const IsoPoint& point : world_.map.points) {
      SupportPoint support{point.position, 0.5, {}};
      for (std::size_t i = 0; i < photos_.size(); ++i) {
        if (Sees(photos_[i].cam_from_world, point)) {
          support.photo_indices.push_back(static_cast<int>(i));
        }
      }
      if (support.photo_indices.size() >= 2) points_.push_back(support);
    }
    input_.camera = kCamera;
    input_.points = &points_;
    engine_.emplace(world_.mesh, VisibilityOptions());
    context_.emplace(SearchContext{options_, input_, *engine_, 625, 2, {}, {}});
  }

  HallWorld world_;
  std::vector<PosedPhoto> photos_ = SouthLine();
  std::vector<SupportPoint> points_;
  NextBestViewOptions options_;
  ViewPlanInput input_{world_.map, world_.mesh, photos_};
  std::optional<VisibilityEngine> engine_;
  std::optional<SearchContext> context_;
};

const ViewDirection kLikeThePhotos{0, DegToRad(-30)};

TEST_F(Overlap, AViewLikeThePhotosSharesWhatTheyHave) {
  const FeatureOverlap overlap(*context_);
  std::size_t seen = 0;
  const Rigid3d pose = CamFromWorld({1, -15, 15}, kLikeThePhotos);
  for (const SupportPoint& point : points_) {
    const Eigen::Vector3d in_cam = pose * point.position;
    seen += kCamera.Contains(kCamera.Project(in_cam), 4) ? 1 : 0;
  }
  // Nearly every feature is found again in this world: all but those at the border.
  EXPECT_NEAR(overlap.Shared({1, -15, 15}, kLikeThePhotos), static_cast<double>(seen),
              0.1 * static_cast<double>(seen));
  EXPECT_GT(seen, 150u);
}

TEST_F(Overlap, LooksFromElsewhereShareLessOrNothing) {
  const FeatureOverlap overlap(*context_);
  const double like = overlap.Shared({0, -15, 15}, kLikeThePhotos);
  EXPECT_LT(overlap.Shared({0, -15, 15}, {DegToRad(40), DegToRad(-30)}), 0.8 * like);
  EXPECT_EQ(overlap.Shared({0, -15, 15}, {DegToRad(180), DegToRad(-30)}), 0);
  EXPECT_EQ(overlap.Shared({0, 15, 15}, {DegToRad(180), DegToRad(-30)}), 0);  // north: 80 degrees
  EXPECT_EQ(overlap.Shared({0, -7, 8}, {0, DegToRad(-10)}), 0);               // near: another scale
  EXPECT_EQ(overlap.Shared({0, -45, 32}, {0, DegToRad(-30)}), 0);             // far
}

TEST_F(Overlap, PlannedViewsPassFeaturesOn) {
  FeatureOverlap overlap(*context_);
  // Round the south-western corner, step by step, always looking at the middle of the south wall.
  const auto view = [](double angle_deg) {
    const double angle = DegToRad(angle_deg);
    const Eigen::Vector3d position(-17 * std::sin(angle), -4 - 17 * std::cos(angle), 12);
    return std::pair(position, ViewDirection{angle, DegToRad(-25)});
  };
  const auto [target, direction] = view(60);
  const double alone = overlap.Shared(target, direction);
  for (const double angle_deg : {20.0, 40.0}) {
    const auto [position, look] = view(angle_deg);
    EXPECT_GT(overlap.Shared(position, look), 0);
    overlap.AddView(position, look);
  }
  EXPECT_GT(overlap.Shared(target, direction), alone + 30);
}

TEST_F(Overlap, CountsOnlyToWhatIsEnough) {
  const FeatureOverlap overlap(*context_);
  FeatureOverlap::Sight sight;
  const double few = overlap.Shared({1, -15, 15}, kLikeThePhotos, 20, &sight);
  EXPECT_GE(few, 20);
  EXPECT_LT(few, 40);
  EXPECT_TRUE(overlap.IsEnough({1, -15, 15}, kLikeThePhotos, &sight));
  FeatureOverlap::Sight other;
  EXPECT_FALSE(overlap.IsEnough({0, 15, 15}, {DegToRad(180), DegToRad(-30)}, &other));
}

TEST_F(Overlap, FeaturesThatAreSeldomFoundCountLess) {
  const double all = FeatureOverlap(*context_).Shared({1, -15, 15}, kLikeThePhotos);
  // Each photo keeps every third of its features only.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    std::vector<int> kept;
    for (const int photo : points_[i].photo_indices) {
      if ((static_cast<std::size_t>(photo) + i) % 3 == 0) kept.push_back(photo);
    }
    points_[i].photo_indices = kept;
  }
  const double third = FeatureOverlap(*context_).Shared({1, -15, 15}, kLikeThePhotos);
  EXPECT_GT(third, 0.2 * all);
  EXPECT_LT(third, 0.5 * all);
}

TEST_F(Overlap, WithoutSparsePointsIsoPointsStandForThem) {
  input_.points = nullptr;
  const FeatureOverlap overlap(*context_);
  EXPECT_GT(overlap.Shared({1, -15, 15}, kLikeThePhotos), 200);
  EXPECT_LT(overlap.Shared({1, -15, 15}, kLikeThePhotos), 800);
  EXPECT_EQ(overlap.Shared({0, 15, 15}, {DegToRad(180), DegToRad(-30)}), 0);
}

}  // namespace
}  // namespace colmap_ext
