#include "colmap_ext/sfm/pairing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

std::vector<PhotoPlace> Line(int count, double spacing_m) {
  std::vector<PhotoPlace> places(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    places[static_cast<std::size_t>(i)].position_m = Eigen::Vector3d(spacing_m * i, 0, 10);
  }
  return places;
}

std::vector<bool> AllNew(const std::vector<PhotoPlace>& places) {
  return std::vector<bool>(places.size(), true);
}

int PartnersOf(const std::vector<PhotoPair>& pairs, int photo) {
  int count = 0;
  for (const PhotoPair& pair : pairs) count += pair.first == photo || pair.second == photo;
  return count;
}

PairingOptions ByRadius() {
  PairingOptions options;
  options.strategy = "radius";
  return options;
}

TEST(ChoosePairs, TakesAllPhotosWithinTheRadiusAndNoOthers) {
  PairingOptions options = ByRadius();
  options.max_distance_m = 5;
  options.min_neighbors = 1;
  const std::vector<PhotoPlace> places = Line(20, 2.0);
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, options);
  EXPECT_EQ(pairs.size(), 19u + 18u);
  for (const PhotoPair& pair : pairs) {
    EXPECT_LT(pair.first, pair.second);
    EXPECT_LE(pair.second - pair.first, 2);
  }
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
}

TEST(ChoosePairs, GivesEveryPhotoItsNearestNeighborsHoweverFar) {
  PairingOptions options;
  options.min_neighbors = 3;
  const std::vector<PhotoPlace> places = Line(10, 100.0);
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, options);
  for (int i = 0; i < 10; ++i) EXPECT_GE(PartnersOf(pairs, i), 3) << i;
}

TEST(ChoosePairs, CapsTheNeighborsWhereManyPhotosWereTakenInOnePlace) {
  PairingOptions options;
  options.min_neighbors = 4;
  options.max_neighbors = 6;
  const std::vector<PhotoPlace> places = Line(200, 0.01);
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, options);
  EXPECT_LE(pairs.size(), 200u * 6u);
  EXPECT_GE(pairs.size(), 200u * 3u);
}

TEST(ChoosePairs, SkipsPhotosThatLookElsewhere) {
  std::vector<PhotoPlace> places = Line(4, 1.0);
  for (std::size_t i = 0; i < 4; ++i) {
    places[i].optical_axis = i < 2 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  }
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, {});
  EXPECT_EQ(pairs, (std::vector<PhotoPair>{{0, 1}, {2, 3}}));
  places[2].optical_axis.reset();  // unknown heading: may look anywhere
  EXPECT_EQ(ChoosePairs(places, AllNew(places), {}, ByRadius()).size(), 4u);
}

// On a circle of 20 m around a tower at the origin, looking at it.
std::vector<PhotoPlace> Circle(int count) {
  std::vector<PhotoPlace> places(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * M_PI * i / count;
    PhotoPlace& place = places[static_cast<std::size_t>(i)];
    place.position_m = Eigen::Vector3d(20 * std::cos(turn), 20 * std::sin(turn), 5);
    place.optical_axis = Eigen::Vector3d(-std::cos(turn), -std::sin(turn), 0);
  }
  return places;
}

TEST(ExpectedOverlap, IsWholeForTheSameViewAndFallsWithTheAngle) {
  const std::vector<PhotoPlace> places = Circle(36);
  EXPECT_NEAR(ExpectedOverlap(places[0], 20, places[0], 20), 1, 1e-12);
  double before = 1;
  for (const std::size_t i : {3u, 4u, 5u}) {
    const double overlap = ExpectedOverlap(places[0], 20, places[i], 20);
    EXPECT_LT(overlap, before) << i;
    EXPECT_NEAR(overlap, ExpectedOverlap(places[i], 20, places[0], 20), 1e-12);
    before = overlap;
  }
  EXPECT_GT(ExpectedOverlap(places[0], 20, places[1], 20), 0.7);
  EXPECT_EQ(ExpectedOverlap(places[0], 20, places[18], 20), 0);  // from behind
}

TEST(ExpectedOverlap, KnowsThatFarNeighborsShowTheSameAndNearOnesMayNot) {
  PhotoPlace near, far, beside;
  near.position_m = Eigen::Vector3d(0, 0, 0);
  far.position_m = Eigen::Vector3d(0, -14, 0);  // 14 m behind
  beside.position_m = Eigen::Vector3d(1, 0, 0);
  near.optical_axis = far.optical_axis = Eigen::Vector3d::UnitY();
  beside.optical_axis = Eigen::Vector3d(std::sin(1.2), std::cos(1.2), 0);  // looks past it
  EXPECT_GT(ExpectedOverlap(near, 30, far, 44), ExpectedOverlap(near, 30, beside, 30) + 0.3);
  // What is known of the surface counts more than a guess of the distance.
  near.seen_points = {{-30, 30, 0}, {-28, 30, 0}, {-29, 31, 0}};
  EXPECT_LT(ExpectedOverlap(near, 30, beside, 30), 0.05);
}

TEST(GuessSceneDistances, FindsWhatThePhotosLookAt) {
  for (const double distance : GuessSceneDistances(Circle(24))) EXPECT_NEAR(distance, 20, 1e-6);
  std::vector<PhotoPlace> down = Line(10, 3.0);
  for (PhotoPlace& place : down) place.optical_axis = -Eigen::Vector3d::UnitZ();
  for (const double distance : GuessSceneDistances(down)) EXPECT_NEAR(distance, 12, 1e-6);
  down[4].seen_points = {{12, 0, 0}, {12, 0, 1}, {12, 0, 2}};
  EXPECT_NEAR(GuessSceneDistances(down)[4], 9, 1e-6);
  down[3].optical_axis.reset();
  EXPECT_EQ(GuessSceneDistances(down)[3], 0);
}

TEST(ChoosePairs, ByOverlapMatchesThoseThatShowTheSame) {
  std::vector<PhotoPlace> places = Circle(36);
  // One more that stands in the ring and looks outward: near to all, shows nothing of the tower.
  places.push_back({Eigen::Vector3d(20, 1, 5), Eigen::Vector3d::UnitX(), 0.6, 0.45, {}});
  PairingOptions options;
  options.min_neighbors = 1;
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, options);
  EXPECT_EQ(PartnersOf(pairs, 36), 0);
  for (const PhotoPair& pair : pairs) {
    const int steps = std::min(pair.second - pair.first, 36 - pair.second + pair.first);
    EXPECT_LE(steps, 5) << pair.first << " " << pair.second;
  }
  for (int i = 0; i < 36; ++i) EXPECT_GE(PartnersOf(pairs, i), 4) << i;
}

TEST(ChoosePairs, ByOverlapNeedsNoHeadings) {
  std::vector<PhotoPlace> places = Line(12, 2.0);
  EXPECT_EQ(ChoosePairs(places, AllNew(places), {}, {}),
            ChoosePairs(places, AllNew(places), {}, ByRadius()));
  places[5].optical_axis = Eigen::Vector3d::UnitY();
  EXPECT_GE(PartnersOf(ChoosePairs(places, AllNew(places), {}, {}), 5), 11);
}

TEST(ChoosePairs, AddsOnlyPairsWithANewPhotoAndNoneTwice) {
  const std::vector<PhotoPlace> places = Line(30, 2.0);
  std::vector<bool> is_new(30, false);
  is_new[29] = true;
  const std::set<PhotoPair> existing = {{28, 29}};
  const std::vector<PhotoPair> pairs = ChoosePairs(places, is_new, existing, {});
  EXPECT_GE(pairs.size(), 11u);
  for (const PhotoPair& pair : pairs) {
    EXPECT_EQ(pair.second, 29);
    EXPECT_NE(pair.first, 28);
  }
  EXPECT_TRUE(ChoosePairs(places, std::vector<bool>(30, false), {}, {}).empty());
}

TEST(ChoosePairs, MatchesAllPairsOfAFewPhotosWithoutPositions) {
  const std::vector<PhotoPlace> places(12);
  EXPECT_EQ(ChoosePairs(places, AllNew(places), {}, {}).size(), 66u);
}

TEST(ChoosePairs, FollowsTheNameOrderWhenManyPhotosHaveNoPosition) {
  PairingOptions options;
  options.exhaustive_limit = 20;
  options.sequential_overlap = 2;
  const std::vector<PhotoPlace> places(100);
  const std::vector<PhotoPair> pairs = ChoosePairs(places, AllNew(places), {}, options);
  const std::set<PhotoPair> set(pairs.begin(), pairs.end());
  for (int i = 0; i + 64 < 100; ++i) {
    for (const int offset : {1, 2, 4, 8, 64}) EXPECT_TRUE(set.count({i, i + offset}));
    EXPECT_FALSE(set.count({i, i + 3}));
  }
}

TEST(ChoosePairs, MatchesAPhotoWithoutPositionWithPhotosThatHaveOne) {
  std::vector<PhotoPlace> places = Line(9, 500.0);
  places[4].position_m.reset();
  PairingOptions options;
  options.min_neighbors = 1;
  EXPECT_EQ(PartnersOf(ChoosePairs(places, AllNew(places), {}, options), 4), 8);
}

TEST(PairingOptions, NamesWhatIsWrong) {
  PairingOptions options;
  EXPECT_EQ(options.Check(), "");
  options.max_distance_m = std::nan("");
  EXPECT_NE(options.Check().find("max_distance_m"), std::string::npos);
  options = {};
  options.strategy = "best";
  EXPECT_NE(options.Check().find("strategy"), std::string::npos);
  options = {};
  options.min_overlap = 1;
  EXPECT_NE(options.Check().find("min_overlap"), std::string::npos);
  options = {};
  options.max_neighbors = 3;
  EXPECT_THROW(ChoosePairs({}, {}, {}, options), UsageError);
}

}  // namespace
}  // namespace colmap_ext
