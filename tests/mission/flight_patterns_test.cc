#include "colmap_ext/mission/flight_patterns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// About the size of the church.
PatternSite ChurchSite() {
  return SiteOfBox(BoundingBox(Eigen::Vector3d(-10, -6, 0), Eigen::Vector3d(10, 6, 19)));
}

std::vector<PlannedView> Make(const std::string& name, int num_views,
                              const PatternSite& site = ChurchSite()) {
  FlightPatternOptions options;
  options.name = name;
  options.num_views = num_views;
  return MakeFlightPattern(site, options);
}

TEST(FlightPatterns, ReachThePapersCounts) {
  EXPECT_EQ(Make("Grid-Downward", 143).size(), 143u);
  EXPECT_EQ(Make("Grid-Multi-Angle", 858).size(), 858u);
  EXPECT_EQ(Make("2-Circles", 105).size(), 105u);
  EXPECT_EQ(Make("Rectangle-Sparse", 130).size(), 130u);
  EXPECT_EQ(Make("rectangle_dense", 390).size(), 390u);
  EXPECT_EQ(Make("initial-rectangle", 0).size(), 64u);
}

TEST(FlightPatterns, ReachEveryCount) {
  for (const int count : {4, 7, 31, 97, 143, 500}) {
    EXPECT_EQ(Make("grid-downward", count).size(), static_cast<std::size_t>(count));
    EXPECT_EQ(Make("2-circles", count).size(), static_cast<std::size_t>(count));
    EXPECT_EQ(Make("rectangle-sparse", count).size(), static_cast<std::size_t>(count));
  }
}

TEST(FlightPatterns, NumberTheirViewsAndStayAboveOrOutside) {
  for (const char* name : {"grid-downward", "grid-multi-angle", "2-circles", "rectangle-sparse",
                           "rectangle-dense", "initial-rectangle"}) {
    const std::vector<PlannedView> views = Make(name, 0);
    ASSERT_GT(views.size(), 3u) << name;
    for (std::size_t i = 0; i < views.size(); ++i) {
      EXPECT_EQ(views[i].id, static_cast<int>(i)) << name;
      const Eigen::AlignedBox3d box(Eigen::Vector3d(-10, -6, 0), Eigen::Vector3d(10, 6, 19));
      EXPECT_GE(box.exteriorDistance(views[i].position), 2) << name << " " << i;
      EXPECT_TRUE(std::abs(views[i].direction.pitch_rad) <= DegToRad(90) + 1e-9) << name;
    }
  }
}

TEST(GridDownward, LooksDownOnLinesBackAndForth) {
  const std::vector<PlannedView> views = Make("grid-downward", 143);
  double longest = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_NEAR(RadToDeg(views[i].direction.pitch_rad), -90, 1e-9);
    EXPECT_NEAR(views[i].position.z(), 29, 1e-9);
    if (i > 0) longest = std::max(longest, (views[i].position - views[i - 1].position).norm());
  }
  EXPECT_LT(longest, 3);  // no flight back across the site between lines
}

TEST(GridDownward, KeepsTheOverlapsThatAreAskedFor) {
  FlightPatternOptions options;
  options.name = "grid-downward";
  options.forward_overlap = 0.8;
  options.side_overlap = 0.6;
  const double across = 2 * options.distance_m * std::tan(DegToRad(80) / 2);
  const double along = across * 368 / 640;
  std::set<double> rows;
  const std::vector<PlannedView> views = MakeFlightPattern(ChurchSite(), options);
  for (const PlannedView& view : views) rows.insert(view.position.y());
  double last = *rows.begin();
  for (const double row : rows) {
    EXPECT_LE(row - last, across * 0.4 + 1e-9);
    last = row;
  }
  EXPECT_LE(views[1].position.x() - views[0].position.x(), along * 0.2 + 1e-9);
  EXPECT_NEAR(*rows.begin(), -6, 1e-9);
  EXPECT_NEAR(*rows.rbegin(), 6, 1e-9);
}

TEST(GridMultiAngle, HasOnePhotoDownAndTheOthersAround) {
  const std::vector<PlannedView> views = Make("grid-multi-angle", 858);
  std::set<int> headings;
  int down = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(views[i].position, views[0].position);
    if (std::abs(RadToDeg(views[i].direction.pitch_rad) + 90) < 1e-6) {
      ++down;
    } else {
      EXPECT_NEAR(RadToDeg(views[i].direction.pitch_rad), -45, 1e-9);
      headings.insert(static_cast<int>(std::lround(RadToDeg(views[i].direction.yaw_rad))));
    }
  }
  EXPECT_EQ(down, 1);
  EXPECT_EQ(headings.size(), 5u);
  EXPECT_THROW(Make("grid-multi-angle", 143), UsageError);
}

TEST(Circles, LookAtTheMiddleFromTwoHeights) {
  const std::vector<PlannedView> views = Make("2-circles", 105);
  std::set<double> heights;
  for (const PlannedView& view : views) {
    heights.insert(view.position.z());
    const Eigen::Vector3d to_middle = (Eigen::Vector3d(0, 0, 9.5) - view.position).normalized();
    EXPECT_LT((DirectionInWorld(view.direction) - to_middle).norm(), 1e-9) << view.id;
    EXPECT_NEAR(view.position.head<2>().norm(), std::hypot(10, 6) + 10, 1e-9);
  }
  EXPECT_EQ(heights.size(), 2u);
}

TEST(RectangleDense, HasThreeLevelsThatLookMoreSteeplyFromHigher) {
  const std::vector<PlannedView> views = Make("rectangle-dense", 390);
  std::set<double> heights;
  for (const PlannedView& view : views) heights.insert(view.position.z());
  EXPECT_EQ(heights.size(), 3u);
  EXPECT_NEAR(RadToDeg(views[0].direction.pitch_rad), -15, 1e-9);
  EXPECT_NEAR(RadToDeg(views[389].direction.pitch_rad), -45, 1e-9);
  EXPECT_LT(views[0].position.z(), views[389].position.z());
}

TEST(SiteOfZone, FindsTheSmallestBoxWhicheverWayItIsTurned) {
  // 40 by 20 m, turned by 30 degrees, about (100, 50).
  FlightZone zone;
  const Eigen::Rotation2Dd turn(DegToRad(30));
  std::vector<Eigen::Vector2d> ring;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(-20, -10), {20, -10}, {20, 10}, {0, 9}, {-20, 10}}) {
    ring.push_back(Eigen::Vector2d(100, 50) + turn * corner);
  }
  zone.rings = {ring};
  zone.max_z_m = 12;
  const PatternSite site = SiteOfZone(zone, 1, 30);
  EXPECT_NEAR((site.center - Eigen::Vector2d(100, 50)).norm(), 0, 1e-9);
  EXPECT_NEAR(site.half_extent.maxCoeff(), 20, 1e-9);
  EXPECT_NEAR(site.half_extent.minCoeff(), 10, 1e-9);
  EXPECT_EQ(site.min_z_m, 1);
  EXPECT_EQ(site.max_z_m, 12);
  // The pattern turns with it: all views look at right angles to a side, or around a corner, and
  // keep the distance.
  for (const PlannedView& view : Make("rectangle-sparse", 100, site)) {
    const Eigen::Vector2d own =
        turn.inverse() * (view.position.head<2>() - Eigen::Vector2d(100, 50));
    EXPECT_NEAR(std::max(std::abs(own.x()) - 20, std::abs(own.y()) - 10), 10, 1e-9);
    const Eigen::Vector3d look = DirectionInWorld(view.direction);
    EXPECT_LT(look.head<2>().dot(view.position.head<2>() - Eigen::Vector2d(100, 50)), 0);
  }
}

TEST(FlightPatterns, AGridLeavesOutWhatIsFarOutsideOfThePolygon) {
  FlightZone triangle;
  triangle.rings = {{{0, 0}, {100, 0}, {0, 100}}};
  const PatternSite site = SiteOfZone(triangle, 0, 10);
  FlightPatternOptions options;
  options.name = "grid-downward";
  const std::size_t inside = MakeFlightPattern(site, options).size();
  PatternSite box = site;
  box.outline.clear();
  const std::size_t all = MakeFlightPattern(box, options).size();
  EXPECT_LT(static_cast<double>(inside), 0.7 * static_cast<double>(all));
  EXPECT_GT(static_cast<double>(inside), 0.45 * static_cast<double>(all));
}

TEST(FlightPatterns, RefuseBadInput) {
  EXPECT_THROW(Make("zigzag", 10), UsageError);
  EXPECT_THROW(Make("rectangle-dense", 5), UsageError);
  EXPECT_THROW(Make("grid-downward", 3), UsageError);
  EXPECT_THROW(Make("grid-downward", 10, PatternSite{}), Error);
  EXPECT_THROW(SiteOfZone(FlightZone{}, 0, 1), Error);
  FlightPatternOptions options;
  options.name = "grid-downward";
  options.distance_m = 0.01;
  options.forward_overlap = 0.95;
  EXPECT_THROW(MakeFlightPattern(ChurchSite(), options), Error);
  options.distance_m = -1;
  EXPECT_THROW(MakeFlightPattern(ChurchSite(), options), UsageError);
}

}  // namespace
}  // namespace colmap_ext
