#include "colmap_ext/sfm/matching.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "colmap_ext/util/error.h"
#include "sfm/descriptor_kernel.h"

namespace colmap_ext {
namespace {

using Bytes = std::vector<std::uint8_t>;

DescriptorView ViewOf(const Bytes& bytes) {
  return {bytes.data(), static_cast<int>(bytes.size()) / kDescriptorSize};
}

// Random descriptors of length about 512, as COLMAP writes them.
Bytes RandomDescriptors(int count, unsigned seed) {
  std::mt19937 generator(seed);
  std::exponential_distribution<double> value(1.0);
  Bytes bytes;
  for (int i = 0; i < count; ++i) {
    std::vector<double> row(kDescriptorSize);
    double square = 0;
    for (double& x : row) {
      x = value(generator);
      square += x * x;
    }
    for (const double x : row) {
      bytes.push_back(static_cast<std::uint8_t>(std::min(255.0, 512 * x / std::sqrt(square))));
    }
  }
  return bytes;
}

// `original` shuffled, with noise: descriptor i of the result is descriptor order[i].
Bytes NoisyCopy(const Bytes& original, const std::vector<int>& order, int noise, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<int> delta(-noise, noise);
  Bytes copy;
  for (const int i : order) {
    for (int k = 0; k < kDescriptorSize; ++k) {
      const int value =
          original[static_cast<std::size_t>(i * kDescriptorSize + k)] + delta(generator);
      copy.push_back(static_cast<std::uint8_t>(std::clamp(value, 0, 255)));
    }
  }
  return copy;
}

std::int32_t Dot(const DescriptorView& a, int i, const DescriptorView& b, int j) {
  std::int32_t sum = 0;
  for (int k = 0; k < kDescriptorSize; ++k) {
    sum += a.bytes[i * kDescriptorSize + k] * b.bytes[j * kDescriptorSize + k];
  }
  return sum;
}

// The definition, written as slowly as it reads.
std::vector<BestTwo> SlowBestTwo(const DescriptorView& a, const DescriptorView& b) {
  std::vector<BestTwo> all(static_cast<std::size_t>(a.count));
  for (int i = 0; i < a.count; ++i) {
    BestTwo& two = all[static_cast<std::size_t>(i)];
    for (int j = 0; j < b.count; ++j) {
      const std::int32_t dot = Dot(a, i, b, j);
      if (dot > two.best) {
        two = {dot, two.best, j};
      } else if (dot > two.second) {
        two.second = dot;
      }
    }
  }
  return all;
}

class EveryCpuPath : public testing::TestWithParam<CpuPath> {};

TEST_P(EveryCpuPath, FindsExactlyWhatTheDefinitionSays) {
  for (const auto& [na, nb] : std::vector<std::pair<int, int>>{
           {1, 1}, {3, 17}, {4, 16}, {33, 5}, {130, 95}, {0, 7}, {7, 0}}) {
    const Bytes a = RandomDescriptors(na, 1), b = RandomDescriptors(nb, 2);
    const BestTwoBothWays found = FindBestTwo(ViewOf(a), ViewOf(b), GetParam());
    EXPECT_EQ(found.of_first, SlowBestTwo(ViewOf(a), ViewOf(b))) << na << " x " << nb;
    EXPECT_EQ(found.of_second, SlowBestTwo(ViewOf(b), ViewOf(a))) << na << " x " << nb;
  }
}

TEST_P(EveryCpuPath, BreaksTiesByTheLowestIndex) {
  Bytes b = RandomDescriptors(40, 3);
  const Bytes a(b.begin(), b.begin() + kDescriptorSize);
  for (const int twin : {5, 21, 39}) {
    std::copy(a.begin(), a.end(), b.begin() + twin * kDescriptorSize);
  }
  const BestTwoBothWays found = FindBestTwo(ViewOf(a), ViewOf(b), GetParam());
  EXPECT_EQ(found.of_first[0].index, 0);
  EXPECT_EQ(found.of_first[0].best, found.of_first[0].second);
}

TEST_P(EveryCpuPath, DoesNotOverflowOnTheLargestBytes) {
  const Bytes a(4 * kDescriptorSize, 255), b(16 * kDescriptorSize, 255);
  EXPECT_EQ(FindBestTwo(ViewOf(a), ViewOf(b), GetParam()).of_first[3].best,
            kDescriptorSize * 255 * 255);
}

TEST_P(EveryCpuPath, FindsNothingAmongZeros) {
  const Bytes a(5 * kDescriptorSize, 0);
  EXPECT_EQ(FindBestTwo(ViewOf(a), ViewOf(a), GetParam()).of_first[4], BestTwo{});
}

INSTANTIATE_TEST_SUITE_P(Kernels, EveryCpuPath, testing::ValuesIn(AvailableCpuPaths()));

TEST(MatchDescriptors, FindsAShuffledNoisyCopy) {
  const Bytes a = RandomDescriptors(200, 4);
  std::vector<int> order(200);
  for (int i = 0; i < 200; ++i) order[static_cast<std::size_t>(i)] = (i * 37) % 200;
  const Bytes b = NoisyCopy(a, order, 6, 5);
  const std::vector<KeypointMatch> matches = MatchDescriptors(ViewOf(a), ViewOf(b), {});
  EXPECT_GT(matches.size(), 195u);
  for (const KeypointMatch& match : matches) {
    EXPECT_EQ(static_cast<int>(match.first), order[match.second]);
  }
  EXPECT_TRUE(std::is_sorted(matches.begin(), matches.end()));
}

TEST(MatchDescriptors, RejectsAmbiguousAndDistantOnes) {
  Bytes a = RandomDescriptors(1, 6);
  Bytes b = a;
  b.insert(b.end(), a.begin(), a.end());  // two equally good ones
  EXPECT_TRUE(MatchDescriptors(ViewOf(a), ViewOf(b), {}).empty());
  const Bytes c = RandomDescriptors(30, 7), d = RandomDescriptors(30, 8);  // unrelated
  EXPECT_TRUE(MatchDescriptors(ViewOf(c), ViewOf(d), {}).empty());
  MatchingOptions loose;
  loose.max_ratio = 1.0;
  loose.max_distance = 1.5;
  loose.cross_check = false;
  EXPECT_GT(MatchDescriptors(ViewOf(c), ViewOf(d), loose).size(), 25u);
}

TEST(MatchDescriptors, CrossCheckKeepsOnlyMutualMatches) {
  const Bytes a = RandomDescriptors(60, 9), b = RandomDescriptors(60, 10);
  MatchingOptions options;
  options.max_ratio = 1.0;
  options.max_distance = 1.5;
  const std::vector<KeypointMatch> forward = MatchDescriptors(ViewOf(a), ViewOf(b), options);
  std::vector<KeypointMatch> backward = MatchDescriptors(ViewOf(b), ViewOf(a), options);
  for (KeypointMatch& match : backward) std::swap(match.first, match.second);
  std::sort(backward.begin(), backward.end());
  EXPECT_EQ(forward, backward);
  EXPECT_FALSE(forward.empty());
}

TEST(MatchPhotoPairs, GivesTheSameWithAnyNumberOfThreads) {
  std::vector<Bytes> photos;
  for (unsigned i = 0; i < 6; ++i) photos.push_back(RandomDescriptors(80, 20 + i / 2));
  std::vector<DescriptorView> views;
  for (const Bytes& photo : photos) views.push_back(ViewOf(photo));
  std::vector<PhotoPair> pairs;
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) pairs.emplace_back(i, j);
  }
  const auto many = MatchPhotoPairs(views, pairs, {}, {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, MatchPhotoPairs(views, pairs, {}, {}));
  EXPECT_EQ(many[0].size(), 80u);  // photos 0 and 1 are the same
  EXPECT_EQ(many[1].size(), 0u);
}

TEST(MatchPhotoPairs, StopsOnRequest) {
  const Bytes photo = RandomDescriptors(10, 1);
  const std::atomic<bool> cancel = true;
  EXPECT_THROW(MatchPhotoPairs({ViewOf(photo), ViewOf(photo)}, {{0, 1}}, {}, {nullptr, &cancel}),
               CancelledError);
}

TEST(MatchingOptions, NamesWhatIsWrong) {
  MatchingOptions options;
  EXPECT_EQ(options.Check(), "");
  options.max_ratio = 0;
  EXPECT_THROW(MatchDescriptors({}, {}, options), UsageError);
  options = {};
  options.max_distance = 2;
  EXPECT_NE(options.Check().find("max_distance"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
