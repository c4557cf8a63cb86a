#include "nbv/view_tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace colmap_ext {
namespace {

std::vector<Eigen::Vector3d> RandomPlaces(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(0, 50);
  std::vector<Eigen::Vector3d> places;
  for (std::size_t i = 0; i < count; ++i) {
    places.emplace_back(coordinate(random), coordinate(random), 0.3 * coordinate(random));
  }
  return places;
}

double LengthOf(const Eigen::Vector3d& start, const std::vector<Eigen::Vector3d>& places,
                const std::vector<std::size_t>& order, bool is_return) {
  Eigen::Vector3d place = start;
  double length = 0;
  for (const std::size_t k : order) {
    length += (places[k] - place).norm();
    place = places[k];
  }
  return is_return ? length + (start - place).norm() : length;
}

TEST(ViewTour, IsAsLongAsItsLegs) {
  const Eigen::Vector3d start(25, 25, 0);
  for (const bool is_return : {false, true}) {
    NextBestViewOptions options;
    options.return_to_start = is_return;
    ViewTour tour(start, options);
    EXPECT_EQ(tour.length_m(), 0);
    const std::vector<Eigen::Vector3d> places = RandomPlaces(40, 3);
    for (const Eigen::Vector3d& place : places) {
      const double before = tour.length_m();
      const double extra = tour.ExtraLength(place);
      tour.Insert(place);
      EXPECT_LE(tour.length_m(), before + extra + 1e-9);  // 2-opt may shorten it further
      EXPECT_NEAR(tour.length_m(), LengthOf(start, places, tour.order(), is_return), 1e-9);
    }
    std::vector<std::size_t> sorted = tour.order();
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i);
    EXPECT_NEAR(tour.duration_s(), tour.length_m() / 3 + 40 * (4 + 1), 1e-9);
  }
}

TEST(ViewTour, IsNearlyTheShortest) {
  const Eigen::Vector3d start = Eigen::Vector3d::Zero();
  double worst = 1;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<Eigen::Vector3d> places = RandomPlaces(7, seed);
    const NextBestViewOptions options;
    ViewTour tour(start, options);
    for (const Eigen::Vector3d& place : places) tour.Insert(place);
    std::vector<std::size_t> order(places.size());
    std::iota(order.begin(), order.end(), 0);
    double shortest = std::numeric_limits<double>::infinity();
    do {
      shortest = std::min(shortest, LengthOf(start, places, order, false));
    } while (std::next_permutation(order.begin(), order.end()));
    worst = std::max(worst, tour.length_m() / shortest);
  }
  EXPECT_LT(worst, 1.25);
  EXPECT_GE(worst, 1);
}

TEST(ViewTour, PermitsWhatTheBudgetsAllow) {
  NextBestViewOptions options;
  options.max_tour_length_m = 20;
  ViewTour tour(Eigen::Vector3d::Zero(), options);
  EXPECT_TRUE(tour.Permits({19, 0, 0}));
  EXPECT_FALSE(tour.Permits({21, 0, 0}));
  tour.Insert({15, 0, 0});
  EXPECT_TRUE(tour.Permits({8, 0, 0}));  // on the way
  EXPECT_FALSE(tour.Permits({15, 6, 0}));
  NextBestViewOptions back = options;
  back.return_to_start = true;
  const ViewTour there_and_back(Eigen::Vector3d::Zero(), back);
  EXPECT_TRUE(there_and_back.Permits({9, 0, 0}));
  EXPECT_FALSE(there_and_back.Permits({11, 0, 0}));
  options.max_tour_length_m = 0;
  options.max_tour_duration_s = 5 + 5 + 5;  // 15 m, and 5 s for each of two photos
  EXPECT_TRUE(tour.Permits({8, 0, 0}));
  options.max_tour_duration_s = 14;
  EXPECT_FALSE(tour.Permits({8, 0, 0}));
}

}  // namespace
}  // namespace colmap_ext
