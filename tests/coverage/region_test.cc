#include "colmap_ext/coverage/region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "colmap_ext/util/error.h"
#include "coverage/convex_hull.h"
#include "coverage/test_scene.h"

namespace colmap_ext {
namespace {

using ::testing::HasSubstr;

WorldFrame Enu() { return {true, std::nullopt}; }

std::string MessageOf(const PhotoSet& photos, const RegionOptions& options) {
  try {
    DefaultRegion(photos, Enu(), options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void AddPoint(const Eigen::Vector3d& position, PhotoSet* set) {
  SupportPoint point;
  point.position = position;
  for (std::size_t i = 0; i < set->photos.size(); ++i) {
    const PosedPhoto& photo = set->photos[i];
    const Eigen::Vector3d in_cam = photo.cam_from_world * position;
    if (in_cam.z() > 0 && photo.camera.Contains(photo.camera.Project(in_cam))) {
      point.photo_indices.push_back(static_cast<int>(i));
    }
  }
  if (!point.photo_indices.empty()) set->points.push_back(point);
}

// Ground points over ±40 m, and points of the box [-6, 6] x [-10, 10] x [0, 12], plus outliers.
void AddBuildingAndGround(PhotoSet* set) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 3000; ++i)
    AddPoint({40 * unit(random), 40 * unit(random), 0.1 * unit(random)}, set);
  for (int i = 0; i < 2000; ++i) {
    const double z = 6 + 6 * unit(random);
    AddPoint({6, 10 * unit(random), z}, set);
    AddPoint({-6, 10 * unit(random), z}, set);
    AddPoint({6 * unit(random), 10 * unit(random), 12}, set);
  }
  for (int i = 0; i < 20; ++i)
    AddPoint({10 * unit(random), 10 * unit(random), 30 * unit(random)}, set);
}

PhotoSet CircleFlight() {
  PhotoSet set;
  for (int i = 0; i < 64; ++i) {
    const double a = 2 * std::numbers::pi * i / 64;
    set.photos.push_back(PhotoTowards({25 * std::cos(a), 25 * std::sin(a), 18}, {0, 0, 6}));
  }
  AddBuildingAndGround(&set);
  return set;
}

TEST(DefaultRegion, BoundsTheBuildingOfAFlightAroundIt) {
  RegionOptions options;
  options.margin_ratio = 0;
  const BoundingBox box = DefaultRegion(CircleFlight(), Enu(), options).box;
  EXPECT_NEAR(box.min().x(), -6, 0.6);
  EXPECT_NEAR(box.max().x(), 6, 0.6);
  EXPECT_NEAR(box.min().y(), -10, 0.6);
  EXPECT_NEAR(box.max().y(), 10, 0.6);
  EXPECT_NEAR(box.min().z(), 0, 0.3);
  EXPECT_NEAR(box.max().z(), 12 * 1.1, 0.6);
}

TEST(DefaultRegion, MarginWidensEachSide) {
  RegionOptions tight, wide;
  tight.margin_ratio = 0;
  wide.margin_ratio = 0.1;
  const PhotoSet set = CircleFlight();
  const BoundingBox inner = DefaultRegion(set, Enu(), tight).box;
  const BoundingBox outer = DefaultRegion(set, Enu(), wide).box;
  const double margin = 0.1 * inner.sizes().head<2>().maxCoeff();
  EXPECT_NEAR((inner.min() - outer.min() - Eigen::Vector3d::Constant(margin)).norm(), 0, 1e-9);
  EXPECT_NEAR((outer.max() - inner.max()).x(), margin, 1e-9);
  EXPECT_NEAR((outer.max() - inner.max()).y(), margin, 1e-9);
  EXPECT_GT(outer.max().z(), inner.max().z() + margin);
}

TEST(DefaultRegion, FlatGroundFromAboveIsAllOfInterest) {
  PhotoSet set;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) set.photos.push_back(PhotoAt({10.0 * x, 10.0 * y, 30}, 0, -90));
  }
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 4000; ++i)
    AddPoint({30 * unit(random), 30 * unit(random), 0.3 * unit(random)}, &set);
  const BoundingBox box = DefaultRegion(set, Enu(), RegionOptions()).box;
  EXPECT_LT(box.min().x(), -18);
  EXPECT_GT(box.max().y(), 18);
  EXPECT_LT(box.min().z(), 0);
}

TEST(DefaultRegion, StraightFlightBoundsWhatItsPhotosCentre) {
  PhotoSet set;
  for (int i = 0; i < 15; ++i)
    set.photos.push_back(PhotoTowards({i - 7.0, -15, 6}, {i - 7.0, 0, 6}));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 2000; ++i) AddPoint({7 * unit(random), 0, 6 + 5 * unit(random)}, &set);
  for (int i = 0; i < 30; ++i) AddPoint({40 + 10 * unit(random), 60, 20 * unit(random)}, &set);
  const BoundingBox box = DefaultRegion(set, Enu(), RegionOptions()).box;
  EXPECT_NEAR(box.min().x(), -7, 1.5);
  EXPECT_NEAR(box.max().x(), 7, 1.5);
  EXPECT_GT(box.min().y(), -3);
  EXPECT_LT(box.max().y(), 3);
}

TEST(DefaultRegion, WorksWhereTheVerticalIsUnknown) {
  const BoundingBox box = DefaultRegion(CircleFlight(), {false, std::nullopt}, RegionOptions()).box;
  EXPECT_TRUE(box.contains(Eigen::Vector3d(6, 9, 6)));
  EXPECT_LT(box.max().z(), 25);
}

TEST(DefaultRegion, UserBoxWins) {
  RegionOptions options;
  options.box = "-1,-2,-3, 4,5.5,6e0";
  const BoundingBox box = DefaultRegion(PhotoSet(), Enu(), options).box;
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, -2, -3));
  EXPECT_EQ(box.max(), Eigen::Vector3d(4, 5.5, 6));
}

TEST(DefaultRegion, TooFewPointsIsAClearError) {
  EXPECT_THAT(MessageOf(PhotoSet(), {}), HasSubstr("only 0 points"));
  EXPECT_THAT(MessageOf(PhotoSet(), {}), HasSubstr("--RegionOfInterest.box"));
}

TEST(ParseBox, RefusesWhatIsNoBox) {
  for (const char* text : {"1,2,3", "a,b,c,d,e,f", "0,0,0,1,1,1,1", "0,0,0,1,1,0", "5,0,0,1,1,1",
                           "0,0,0,1,1,nan", "0 0 0 1 1 1", "0,0,0,1,1,1x", ","}) {
    EXPECT_THROW(ParseBox(text), UsageError) << text;
  }
}

TEST(ParseBox, ReadsBackWhatFormatBoxWrote) {
  const BoundingBox box(Eigen::Vector3d(-1.0 / 3, -1e-7, 0.1), Eigen::Vector3d(1e5 / 7, 2, 3));
  const BoundingBox back = ParseBox(FormatBox(box));
  EXPECT_EQ(back.min(), box.min());
  EXPECT_EQ(back.max(), box.max());
}

TEST(RegionOptions, CheckNamesTheOption) {
  RegionOptions options;
  EXPECT_EQ(options.Check(), "");
  options.margin_ratio = -1;
  EXPECT_THAT(options.Check(), HasSubstr("margin_ratio"));
}

TEST(ConvexHull, KeepsTheCornersOnly) {
  const auto hull = ConvexHull({{0, 0}, {2, 0}, {1, 0}, {2, 2}, {0, 2}, {1, 1}, {0, 0}});
  EXPECT_EQ(hull.size(), 4U);
  EXPECT_NEAR(SignedArea(hull), 4, 1e-12);
  EXPECT_TRUE(IsInside(hull, {1, 2}));
  EXPECT_FALSE(IsInside(hull, {1, 2.01}));
  EXPECT_LT(ConvexHull({{0, 0}, {1, 1}, {2, 2}}).size(), 3U);
}

}  // namespace
}  // namespace colmap_ext
