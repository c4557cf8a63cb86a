#include "colmap_ext/util/statistics.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) throw Error("a quantile of no values");
  const auto rank = std::min(static_cast<std::size_t>(share * static_cast<double>(values.size())),
                             values.size() - 1);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double MiddleValue(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

std::vector<std::size_t> RandomOrder(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 random(seed);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

}  // namespace colmap_ext
