#include "sfm/guided_matching.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr int kPoints = 80;
constexpr float kMaxError = 0.004F;  // on the plane at distance 1: two pixels of 500

// The second camera stands to the right of the first and looks a little inwards.
const Eigen::Matrix3d kRotation =
    Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix();
const Eigen::Vector3d kTranslation(-1, 0.1, 0.05);

Eigen::Matrix3d Essential() {
  Eigen::Matrix3d cross;
  cross << 0, -kTranslation.z(), kTranslation.y(), kTranslation.z(), 0, -kTranslation.x(),
      -kTranslation.y(), kTranslation.x(), 0;
  return cross * kRotation;
}

// Photos of the same points, in the same order. Points 2k and 2k + 1 look the same, as windows of a
// facade do, and are one above the other.
struct Facade {
  Facade() {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> place(-1, 1), depth(4, 6);
    std::exponential_distribution<double> value(1);
    first.resize(2, kPoints);
    second.resize(2, kPoints);
    for (int k = 0; k < kPoints; ++k) {
      const double height = (k % 2 == 0 ? -0.6 : 0.6) + 0.4 * place(generator);
      const Eigen::Vector3d point =
          depth(generator) * Eigen::Vector3d(0.5 * place(generator), 0.5 * height, 1);
      first.col(k) = point.hnormalized().cast<float>();
      second.col(k) = (kRotation * point + kTranslation).hnormalized().cast<float>();
      if (k % 2 == 0) look = LookOf(&generator, &value);
      bytes.insert(bytes.end(), look.begin(), look.end());
    }
  }

  static std::vector<std::uint8_t> LookOf(std::mt19937* generator,
                                          std::exponential_distribution<double>* value) {
    Eigen::ArrayXd row(kDescriptorSize);
    for (double& x : row) x = (*value)(*generator);
    row *= 512 / row.matrix().norm();
    std::vector<std::uint8_t> result;
    for (const double x : row) result.push_back(static_cast<std::uint8_t>(std::min(x, 255.0)));
    return result;
  }

  GuidedPhoto First() const { return {first, {bytes.data(), kPoints}, kMaxError}; }
  GuidedPhoto Second() const { return {second, {bytes.data(), kPoints}, kMaxError}; }

  Eigen::Matrix2Xf first, second;
  std::vector<std::uint8_t> bytes, look;
};

int NumTrue(const std::vector<KeypointMatch>& matches) {
  return static_cast<int>(std::count_if(matches.begin(), matches.end(), [](const auto& match) {
    return match.first == match.second;
  }));
}

TEST(AddGuidedMatches, TellsApartWhatLooksTheSame) {
  const Facade facade;
  const GuidedPhoto first = facade.First(), second = facade.Second();
  EXPECT_TRUE(MatchDescriptors(first.descriptors, second.descriptors, {}).empty());
  const auto matches = AddGuidedMatches(first, second, Essential(), {}, {});
  EXPECT_GT(matches.size(), 70u);
  EXPECT_EQ(NumTrue(matches), static_cast<int>(matches.size()));
  EXPECT_TRUE(std::is_sorted(matches.begin(), matches.end()));
}

TEST(AddGuidedMatches, IsTheSameFromEitherPhoto) {
  const Facade facade;
  const auto forth = AddGuidedMatches(facade.First(), facade.Second(), Essential(), {}, {});
  const auto back =
      AddGuidedMatches(facade.Second(), facade.First(), Essential().transpose(), {}, {});
  ASSERT_EQ(forth.size(), back.size());
  for (std::size_t k = 0; k < forth.size(); ++k) {
    EXPECT_TRUE(std::binary_search(back.begin(), back.end(),
                                   KeypointMatch(forth[k].second, forth[k].first)));
  }
}

TEST(AddGuidedMatches, KeepsWhatIsGivenAndUsesEachKeypointOnce) {
  const Facade facade;
  const std::vector<KeypointMatch> given = {{3, 7}, {10, 10}};
  const auto matches = AddGuidedMatches(facade.First(), facade.Second(), Essential(), given, {});
  std::set<std::uint32_t> seen_first, seen_second;
  for (const auto& [a, b] : matches) {
    EXPECT_TRUE(seen_first.insert(a).second);
    EXPECT_TRUE(seen_second.insert(b).second);
  }
  for (const KeypointMatch& match : given) {
    EXPECT_TRUE(std::binary_search(matches.begin(), matches.end(), match));
  }
}

TEST(AddGuidedMatches, LeavesOutWhatIsOffItsLine) {
  Facade facade;
  facade.second.row(1).array() += 4 * kMaxError;
  const auto matches = AddGuidedMatches(facade.First(), facade.Second(), Essential(), {}, {});
  EXPECT_EQ(NumTrue(matches), 0);
}

TEST(AddGuidedMatches, TakesPhotosWithoutFeaturesAndRefusesBadOptions) {
  const Facade facade;
  const GuidedPhoto empty = {Eigen::Matrix2Xf(2, 0), {nullptr, 0}, kMaxError};
  EXPECT_TRUE(AddGuidedMatches(facade.First(), empty, Essential(), {}, {}).empty());
  EXPECT_TRUE(AddGuidedMatches(empty, facade.Second(), Essential(), {}, {}).empty());
  MatchingOptions options;
  options.guided_max_error_px = -1;
  EXPECT_NE(options.Check().find("Matching.guided_max_error_px"), std::string::npos);
  EXPECT_THROW(AddGuidedMatches(facade.First(), facade.Second(), Essential(), {}, options),
               UsageError);
}

}  // namespace
}  // namespace colmap_ext
