#include "colmap_ext/coverage/coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "colmap_ext/util/error.h"
#include "coverage/test_scene.h"

namespace colmap_ext {
namespace {

using ::testing::HasSubstr;
using Photos = std::vector<PosedPhoto>;

// The wall's middle (|x| < 1.5, |z - 3| < 1), which the cameras of these tests have in view.
bool IsInMiddle(const IsoPoint& point) {
  return std::abs(point.position.x()) < 1.5 && std::abs(point.position.z() - 3) < 1;
}

// What the numbers below are made for.
CoverageOptions FortyMillimetres() {
  CoverageOptions options;
  options.ground_sampling_distance_mm = 40;
  return options;
}

CoverageMap Evaluate(const Surface& surface, const Photos& photos,
                     const CoverageOptions& options = FortyMillimetres()) {
  CoverageOptions with_spacing = options;
  with_spacing.iso_point_spacing_m = 0.2;
  return EvaluateCoverage(surface, photos, Everything(), with_spacing, JobControl());
}

// The class of all points in the middle; fails when they differ.
CoverageClass ClassOfMiddle(const CoverageMap& map) {
  std::vector<CoverageClass> classes;
  for (const IsoPoint& point : map.points) {
    if (IsInMiddle(point)) classes.push_back(point.coverage);
  }
  EXPECT_GT(classes.size(), 50U);
  EXPECT_THAT(classes, ::testing::Each(classes.front()));
  return classes.front();
}

// Two cameras `distance` away from the wall's middle whose rays meet there at `angle_deg`.
Photos PairAtAngle(double angle_deg, double distance) {
  Photos photos;
  for (const double side : {-0.5, 0.5}) {
    const double angle = DegToRad(side * angle_deg);
    const Eigen::Vector3d position(distance * std::sin(angle), -distance * std::cos(angle), 3);
    photos.push_back(PhotoTowards(position, {0, 0, 3}));
  }
  return photos;
}

TEST(EvaluateCoverage, TwoGoodViewsAtAGoodAngleCover) {
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), PairAtAngle(10, 10))), CoverageClass::kCovered);
}

TEST(EvaluateCoverage, OneViewDoesNotCover) {
  const CoverageMap map = Evaluate(Wall(), {PhotoAt({0, -10, 3}, 0)});
  EXPECT_EQ(ClassOfMiddle(map), CoverageClass::kUncovered);
  for (const IsoPoint& point : map.points) {
    if (!IsInMiddle(point)) continue;
    EXPECT_EQ(point.num_good_views, 1);
    EXPECT_GT(point.predicted_error_mm, 0);
  }
}

TEST(EvaluateCoverage, TooWideAndTooNarrowPairsDoNotCover) {
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), PairAtAngle(45, 10))), CoverageClass::kUncovered);
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), PairAtAngle(0.5, 10))), CoverageClass::kUncovered);
  // Together the four make pairs of 22 degrees.
  Photos photos = PairAtAngle(45, 10);
  const Photos narrow = PairAtAngle(0.5, 10);
  photos.insert(photos.end(), narrow.begin(), narrow.end());
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), photos)), CoverageClass::kCovered);
}

TEST(EvaluateCoverage, ViewsFromTooFarAreNotGood) {
  const Photos far = PairAtAngle(10, 22);  // 467 px at 22 m: 47 mm a pixel
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), far)), CoverageClass::kUncovered);
  CoverageOptions coarser;
  coarser.ground_sampling_distance_mm = 60;
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), far, coarser)), CoverageClass::kCovered);
}

TEST(EvaluateCoverage, HiddenPatchIsToldApartFromTheSeenOne) {
  Surface surface = Wall();
  const Photos photos = PairAtAngle(10, 10);
  AppendPanel({0, -5, 0}, {4, 0, 0}, {0, 0, 6}, 10, &surface.mesh);  // in front of the right half
  int covered = 0, hidden = 0;
  for (const IsoPoint& point : Evaluate(surface, photos).points) {
    if (point.position.y() < -1 || std::abs(point.position.z() - 3) > 1) continue;
    // The panel's left edge, seen from x = ±0.87, hides from x = ±0.87 on.
    if (point.position.x() > -2 && point.position.x() < -0.95) {
      EXPECT_EQ(point.coverage, CoverageClass::kCovered);
      ++covered;
    }
    if (point.position.x() > 0.95 && point.position.x() < 4) {
      EXPECT_EQ(point.num_good_views, 0);
      EXPECT_EQ(point.coverage, CoverageClass::kUncovered);
      ++hidden;
    }
  }
  EXPECT_GT(covered, 20);
  EXPECT_GT(hidden, 50);
}

TEST(EvaluateCoverage, TheBackOfTheWallIsNotCovered) {
  Photos photos;
  for (const double x : {-1.0, 1.0}) photos.push_back(PhotoAt({x, 10, 3}, 180));
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), photos)), CoverageClass::kUncovered);
}

TEST(EvaluateCoverage, StrongSignalCoversWithoutViews) {
  EXPECT_EQ(ClassOfMiddle(Evaluate(WithSignal(Wall(), 0.039), {})), CoverageClass::kCovered);
  EXPECT_EQ(ClassOfMiddle(Evaluate(WithSignal(Wall(), 0.041), {})), CoverageClass::kUncovered);
  CoverageOptions options;
  options.strong_spacing_m = 0.2;
  EXPECT_EQ(ClassOfMiddle(Evaluate(WithSignal(Wall(), 0.15), {}, options)),
            CoverageClass::kCovered);
}

TEST(EvaluateCoverage, GeometryDecidesOnUnsupportedSurfaceUnlessAsked) {
  const Surface unsupported = WithSignal(Wall(), 3.0);
  EXPECT_EQ(ClassOfMiddle(Evaluate(unsupported, PairAtAngle(10, 10))), CoverageClass::kCovered);
  CoverageOptions options;
  options.unsupported_spacing_m = 1;
  EXPECT_EQ(ClassOfMiddle(Evaluate(unsupported, PairAtAngle(10, 10), options)),
            CoverageClass::kUncovered);
  // A mesh of unknown origin has no signal to disbelieve.
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), PairAtAngle(10, 10), options)), CoverageClass::kCovered);
}

TEST(EvaluateCoverage, OutsideTheRegionIsIgnored) {
  const RegionOfInterest left{BoundingBox(Eigen::Vector3d(-9, -1, -1), Eigen::Vector3d(0, 1, 9))};
  const CoverageMap map =
      EvaluateCoverage(Wall(), PairAtAngle(10, 10), left, CoverageOptions(), JobControl());
  for (const IsoPoint& point : map.points) {
    EXPECT_EQ(point.coverage == CoverageClass::kIgnored, point.position.x() > 0);
  }
  EXPECT_NEAR(static_cast<double>(map.Count(CoverageClass::kIgnored)) * map.disk_area_m2, 30, 1);
}

TEST(EvaluateCoverage, MinGoodViewsIsObeyed) {
  CoverageOptions options;
  options.min_good_views = 3;
  Photos photos = PairAtAngle(10, 10);
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), photos, options)), CoverageClass::kUncovered);
  photos.push_back(PhotoAt({0, -10, 3}, 0));
  EXPECT_EQ(ClassOfMiddle(Evaluate(Wall(), photos, options)), CoverageClass::kCovered);
}

Photos RandomPhotos(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  Photos photos;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d position(8 * unit(random), -12 + 6 * unit(random), 4 + 3 * unit(random));
    photos.push_back(PhotoTowards(position, {4 * unit(random), 0, 3 + 2 * unit(random)}));
  }
  return photos;
}

TEST(EvaluateCoverage, APhotoMoreNeverUncovers) {
  Surface surface = Wall();
  AppendPanel({-1, -4, 0}, {2, 0, 0}, {0, 0, 5}, 10, &surface.mesh);
  const Photos all = RandomPhotos(9, 11);
  CoverageMap before = Evaluate(surface, {});
  std::size_t gained = 0;
  for (std::size_t n = 1; n <= all.size(); ++n) {
    const Photos some(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
    const CoverageMap after = Evaluate(surface, some);
    ASSERT_EQ(after.points.size(), before.points.size());
    for (std::size_t i = 0; i < after.points.size(); ++i) {
      const IsoPoint &was = before.points[i], &is = after.points[i];
      EXPECT_GE(static_cast<int>(is.coverage), static_cast<int>(was.coverage));
      EXPECT_GE(is.num_good_views, was.num_good_views);
      if (was.predicted_error_mm >= 0) {
        EXPECT_GE(is.predicted_error_mm, 0);
        EXPECT_LE(is.predicted_error_mm, was.predicted_error_mm);
      }
      gained += is.coverage != was.coverage ? 1U : 0U;
    }
    before = after;
  }
  EXPECT_GT(gained, 100U);
}

TEST(EvaluateCoverage, SameMapWhateverTheThreads) {
  const Photos photos = RandomPhotos(20, 5);
  const CoverageMap parallel = Evaluate(Wall(), photos);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const CoverageMap serial = Evaluate(Wall(), photos);
  ASSERT_EQ(parallel.points.size(), serial.points.size());
  for (std::size_t i = 0; i < serial.points.size(); ++i) {
    EXPECT_EQ(parallel.points[i].position, serial.points[i].position);
    EXPECT_EQ(parallel.points[i].coverage, serial.points[i].coverage);
    EXPECT_EQ(parallel.points[i].num_good_views, serial.points[i].num_good_views);
    EXPECT_EQ(parallel.points[i].predicted_error_mm, serial.points[i].predicted_error_mm);
  }
}

TEST(EvaluateCoverage, StopsWhenCancelled) {
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(EvaluateCoverage(Wall(), {}, Everything(), {}, JobControl(nullptr, &cancel)),
               CancelledError);
}

TEST(EvaluateCoverage, BadInputIsRefused) {
  EXPECT_THROW(Evaluate(Surface(), {}), Error);
  CoverageOptions options;
  options.min_good_views = 1;
  EXPECT_THROW(Evaluate(Wall(), {}, options), UsageError);
  EXPECT_THAT(options.Check(), HasSubstr("min_good_views"));
  options = {};
  options.max_angle_deg = 1;
  EXPECT_THAT(options.Check(), HasSubstr("max_angle_deg"));
  options = {};
  options.ground_sampling_distance_mm = 0;
  EXPECT_THAT(options.Check(), HasSubstr("ground_sampling_distance_mm"));
  options = {};
  options.visibility.border_px = -1;
  EXPECT_THAT(options.Check(), HasSubstr("Coverage.border_px"));
}

TEST(EvaluateCoverage, AWantedErrorDecides) {
  const Surface surface = WithSignal(Wall(), 0.05);
  CoverageOptions options = FortyMillimetres();
  options.target_error_mm = 1000;
  // Two views that no stereo matches: the paper's rule and a strict target refuse them, a lax one
  // does not.
  const Photos wide = PairAtAngle(45, 10);
  EXPECT_EQ(ClassOfMiddle(Evaluate(surface, wide, options)), CoverageClass::kCovered);
  options.target_error_mm = 1;
  const Photos good = PairAtAngle(10, 10);
  const CoverageMap strict = Evaluate(surface, good, options);
  EXPECT_EQ(strict.target_error_mm, 1);
  EXPECT_EQ(ClassOfMiddle(strict), CoverageClass::kUncovered);
  options.target_error_mm = 1000;
  EXPECT_EQ(ClassOfMiddle(Evaluate(surface, {}, options)), CoverageClass::kUncovered);
}

TEST(EvaluateCoverage, ScoreIsOneHalfAtTheTarget) {
  CoverageOptions options = FortyMillimetres();
  const Surface surface = WithSignal(Wall(), 0.05);
  const Photos photos = PairAtAngle(10, 10);
  for (const IsoPoint& point : Evaluate(surface, photos, options).points) {
    if (!IsInMiddle(point)) continue;
    options.target_error_mm = point.predicted_error_mm;
    break;
  }
  const CoverageMap map = Evaluate(surface, photos, options);
  for (const IsoPoint& point : map.points) {
    EXPECT_EQ(point.score >= 0.5, point.coverage == CoverageClass::kCovered);
    EXPECT_EQ(point.score == 0, point.predicted_error_mm < 0);
    if (IsInMiddle(point)) {
      EXPECT_NEAR(point.score, 0.5, 0.1);
    }
  }
}

TEST(ThresholdsOf, SayWhatStandsForAutomatic) {
  CoverageOptions options;
  options.ground_sampling_distance_mm = 50;
  EXPECT_NEAR(ThresholdsOf(options).at("strong_spacing_m"), 0.05, 1e-12);
  EXPECT_NEAR(options.MinProjectionRatio(), 400, 1e-9);
}

}  // namespace
}  // namespace colmap_ext
