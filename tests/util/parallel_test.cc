#include "colmap_ext/util/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace colmap_ext {
namespace {

TEST(ParallelFor, CallsEachOnce) {
  std::vector<int> calls(10000, 0);
  ParallelFor(calls.size(), [&](std::size_t i) { ++calls[i]; });
  EXPECT_EQ(std::count(calls.begin(), calls.end(), 1), 10000);
  ParallelFor(0, [](int) { FAIL(); });
}

TEST(ParallelFor, ThrowsWhatACallThrows) {
  const auto loop = [] {
    ParallelFor(1000, [](int i) {
      if (i == 421) throw std::runtime_error("421");
    });
  };
  EXPECT_THROW(loop(), std::runtime_error);
}

}  // namespace
}  // namespace colmap_ext
