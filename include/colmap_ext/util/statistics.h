// Small statistics that several modules need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace colmap_ext {

// The value that `share` (0 … 1) of the values lie below: the one at position floor(share · count)
// in ascending order, the last one for 1. Throws Error when there are none.
double Quantile(std::vector<double> values, double share);

// The upper one of the middle values: Quantile(values, 0.5).
double MiddleValue(std::vector<double> values);

// 0 … count - 1 in random order, the same on every machine (std::shuffle's is not).
std::vector<std::size_t> RandomOrder(std::size_t count, std::uint64_t seed);

}  // namespace colmap_ext
