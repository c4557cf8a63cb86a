#include "colmap_ext/util/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

TEST(Quantile, OfKnownValues) {
  EXPECT_EQ(Quantile({3, 1, 2}, 0), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
  EXPECT_EQ(Quantile({5, 4, 3, 2, 1, 0, 9, 8, 7, 6}, 0.9), 9);
  EXPECT_EQ(MiddleValue({3, 1, 2}), 2);
  EXPECT_EQ(MiddleValue({4, 1, 3, 2}), 3) << "the upper one";
  EXPECT_EQ(MiddleValue({7}), 7);
  EXPECT_THROW(MiddleValue({}), Error);
}

TEST(RandomOrder, IsAPermutationThatTheSeedChooses) {
  std::vector<std::size_t> order = RandomOrder(1000, 5);
  EXPECT_EQ(order, RandomOrder(1000, 5));
  EXPECT_NE(order, RandomOrder(1000, 6));
  EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
  EXPECT_TRUE(RandomOrder(0, 1).empty());
}

}  // namespace
}  // namespace colmap_ext
