#include "colmap_ext/path/segment_check.h"

#include <gtest/gtest.h>

#include <random>

#include "path/box_world.h"

namespace colmap_ext {
namespace {

SegmentRules Rules() {
  SegmentRules rules;
  rules.safe_distance_m = 2;
  rules.position_error_m = 0.5;
  rules.unknown_is_free = true;
  return rules;
}

FreeSpace OpenSpace() { return {SurfaceOf(kBlock), {}, {}, {}}; }

TEST(WhyNotHover, NamesTheRuleThatIsBroken) {
  const FreeSpace space = OpenSpace();
  SegmentRules rules = Rules();
  EXPECT_EQ(WhyNotHover(space, rules, {-8, 0, 5}), "");
  // 2.3 m away: the safe distance alone would do, not with the position error.
  EXPECT_TRUE(Says(WhyNotHover(space, rules, {-7.3, 0, 5}), "2.30 m from the surface"));
  rules.position_error_m = 0;
  EXPECT_EQ(WhyNotHover(space, rules, {-7.3, 0, 5}), "");
  EXPECT_TRUE(Says(WhyNotHover(space, rules, {NAN, 0, 5}), "not finite"));
  rules.max_altitude_m = 20;
  EXPECT_TRUE(Says(WhyNotHover(space, rules, {-8, 0, 20.1}), "ceiling"));
  rules.unknown_is_free = false;
  EXPECT_TRUE(Says(WhyNotHover(space, rules, {-8, 0, 5}), "unknown"));
  EXPECT_EQ(WhyNotHover(space, rules, {-8, 0, 15.1}), "");
}

TEST(WhyNotHover, KeepsThePositionErrorFromFlightLimits) {
  const FreeSpace space = OpenSpace();
  SegmentRules rules = Rules();
  FlightZone fence;
  fence.rings = {{{-20, -20}, {20, -20}, {20, 20}, {-20, 20}}};
  rules.limits.zones = {fence};
  EXPECT_EQ(WhyNotHover(space, rules, {-19.4, 0, 5}), "");
  EXPECT_FALSE(WhyNotHover(space, rules, {-19.6, 0, 5}).empty());
  EXPECT_TRUE(Says(WhyNotHover(space, rules, {-21, 0, 5}), "geofence"));
}

TEST(WhyNotFly, SeesWhatLiesBetweenTheEnds) {
  const FreeSpace space = OpenSpace();
  SegmentRules rules = Rules();
  EXPECT_EQ(WhyNotFly(space, rules, {-20, -12, 5}, {20, -12, 5}), "");
  EXPECT_TRUE(Says(WhyNotFly(space, rules, {-20, 0, 5}, {20, 0, 5}), "surface"));
  FlightZone school;
  school.kind = FlightZone::Kind::kExclusion;
  school.rings = {{{-1, -15}, {1, -15}, {1, -10}, {-1, -10}}};
  rules.limits.zones = {school};
  EXPECT_TRUE(Says(WhyNotFly(space, rules, {-20, -12, 5}, {20, -12, 5}), "limits"));
  rules = Rules();
  rules.max_altitude_m = 13;
  EXPECT_TRUE(Says(WhyNotFly(space, rules, {-20, 0, 5}, {0, 0, 13}), "ceiling"));
}

// Two pieces of known space with a gap between them that is narrower than any step would be.
TEST(IsSegmentKnown, FindsTheGap) {
  FreeSpaceOptions options;
  options.above_top_m = -1;
  options.flown_margin_m = 0;
  SetFreeVolume("-10,-5,0,-0.1,5,10;0.1,-5,0,10,5,10", &options);
  const FreeSpace space(SurfaceOf(kBlock), {}, {}, options);
  EXPECT_TRUE(IsSegmentKnown(space, {-8, 0, 5}, {-1, 0, 5}, 0.5));
  EXPECT_TRUE(IsSegmentKnown(space, {-8, 4, 9}, {-8, -4, 1}, 0.9));
  EXPECT_FALSE(IsSegmentKnown(space, {-8, 0, 5}, {8, 0, 5}, 0));
  EXPECT_FALSE(IsSegmentKnown(space, {-8, 4, 9}, {-8, -4, 1}, 1.1));
}

TEST(WhyNotFly, NeverContradictsADenseSampling) {
  const FreeSpace space = OpenSpace();
  const SegmentRules rules = Rules();
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-15, 15);
  int proved = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Eigen::Vector3d a(place(random), place(random), 8 + place(random) / 2);
    const Eigen::Vector3d b(place(random), place(random), 8 + place(random) / 2);
    if (!WhyNotFly(space, rules, a, b).empty()) continue;
    ++proved;
    EXPECT_GE(SampledClearance(kBlock, {{a, {}, -1}, {b, {}, -1}}), 2.5) << trial;
  }
  EXPECT_GT(proved, 50);
}

}  // namespace
}  // namespace colmap_ext
