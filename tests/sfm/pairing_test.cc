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

TEST(ChoosePairs, TakesAllPhotosWithinTheRadiusAndNoOthers) {
  PairingOptions options;
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
  EXPECT_EQ(ChoosePairs(places, AllNew(places), {}, {}).size(), 4u);
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
  options.max_neighbors = 3;
  EXPECT_THROW(ChoosePairs({}, {}, {}, options), UsageError);
}

}  // namespace
}  // namespace colmap_ext
