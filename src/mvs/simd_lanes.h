// Eight floats at a time, the same to the last bit on every processor: vector types of the
// compiler, compiled once plainly and once for AVX2 (without fused multiply-add, which would round
// otherwise).
#pragma once

#include <cstdint>

#if defined(__x86_64__)
#define COLMAP_EXT_TARGET_AVX2 __attribute__((target("avx2")))
#else
#define COLMAP_EXT_TARGET_AVX2
#endif

namespace colmap_ext {

inline constexpr int kLanes = 8;
using FloatLanes = float __attribute__((vector_size(4 * kLanes)));
using IntLanes = std::int32_t __attribute__((vector_size(4 * kLanes)));

// The same in memory of any alignment.
using FloatLanesAt = float __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));
using IntLanesAt = std::int32_t __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));

// Four double ones.
using DoubleLanes = double __attribute__((vector_size(32)));
using DoubleLanesAt = double __attribute__((vector_size(32), aligned(8), may_alias));

inline bool HasAvx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

// In a fixed order, so that sums are the same everywhere.
inline __attribute__((always_inline)) float SumOfLanes(const FloatLanes& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace colmap_ext
