#include "sim/noise.h"

#include <array>
#include <cmath>
#include <limits>

namespace colmap_ext {
namespace {

float Fade(float t) { return t * t * (3 - 2 * t); }
float Mix(float a, float b, float t) { return a + (b - a) * t; }

// Lattice values come from tables, since textures ask for some 10^9 of them: each coordinate is
// turned into random bits, their exclusive or picks the value. The pattern repeats after 4096
// cells.
constexpr int kTableSize = 4096;
constexpr auto kTableMask = static_cast<std::uint32_t>(kTableSize - 1);
constexpr auto kScramble = [] {
  std::array<std::uint16_t, kTableSize> table{};
  for (std::uint32_t i = 0; i < kTableSize; ++i) {
    table[i] = static_cast<std::uint16_t>(HashBits(i + 1) & kTableMask);
  }
  return table;
}();
constexpr auto kLatticeValue = [] {
  std::array<float, kTableSize> table{};
  for (std::uint32_t i = 0; i < kTableSize; ++i) {
    table[i] = static_cast<float>(HashBits(i + 77777) >> 8) * 0x1p-23F - 1.0F;
  }
  return table;
}();

// Random bits of the cells `cell` and `cell + 1` along one axis.
struct LatticeAxis {
  std::uint32_t low, high;
  LatticeAxis(int cell, std::uint32_t salt)
      : low(kScramble[(static_cast<std::uint32_t>(cell) + salt) & kTableMask]),
        high(kScramble[(static_cast<std::uint32_t>(cell) + 1 + salt) & kTableMask]) {}
};

// Borders of jittered intervals of one unit: where interval k starts.
float IntervalStart(int k, float jitter, std::uint32_t seed) {
  return static_cast<float>(k) + jitter * (HashUnit(k, 17, 3, seed) - 0.5F);
}

int IntervalOf(float x, float jitter, std::uint32_t seed) {
  const int k = FloorInt(x);
  if (x < IntervalStart(k, jitter, seed)) return k - 1;
  if (x >= IntervalStart(k + 1, jitter, seed)) return k + 1;
  return k;
}

}  // namespace

float Noise(const Eigen::Vector2f& p, std::uint32_t seed) {
  const int i = FloorInt(p.x()), j = FloorInt(p.y());
  const float tx = Fade(p.x() - static_cast<float>(i)), ty = Fade(p.y() - static_cast<float>(j));
  const std::uint32_t salt = HashBits(seed);
  const LatticeAxis x(i, salt), y(j, salt >> 12);
  return Mix(Mix(kLatticeValue[x.low ^ y.low], kLatticeValue[x.high ^ y.low], tx),
             Mix(kLatticeValue[x.low ^ y.high], kLatticeValue[x.high ^ y.high], tx), ty);
}

float Noise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const int i = FloorInt(p.x()), j = FloorInt(p.y()), k = FloorInt(p.z());
  const float tx = Fade(p.x() - static_cast<float>(i)), ty = Fade(p.y() - static_cast<float>(j));
  const float tz = Fade(p.z() - static_cast<float>(k));
  const std::uint32_t salt = HashBits(seed);
  const LatticeAxis x(i, salt), y(j, salt >> 10), z(k, salt >> 20);
  const auto layer = [&](std::uint32_t zz) {
    return Mix(Mix(kLatticeValue[x.low ^ y.low ^ zz], kLatticeValue[x.high ^ y.low ^ zz], tx),
               Mix(kLatticeValue[x.low ^ y.high ^ zz], kLatticeValue[x.high ^ y.high ^ zz], tx),
               ty);
  };
  return Mix(layer(z.low), layer(z.high), tz);
}

template <typename Point>
static float SumOctaves(Point p, int octaves, std::uint32_t seed, float gain) {
  float sum = 0, amplitude = 1, total = 0;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * Noise(p, seed + static_cast<std::uint32_t>(i) * 101U);
    total += amplitude;
    amplitude *= gain;
    p = p * 2.03F + Point::Constant(7.31F);
  }
  // Octaves are independent, so their sum rarely comes near the total of the amplitudes.
  return 1.4F * sum / total;
}

float Fbm(const Eigen::Vector3f& p, int octaves, std::uint32_t seed, float gain) {
  return SumOctaves<Eigen::Vector3f>(p, octaves, seed, gain);
}

float Fbm(const Eigen::Vector2f& p, int octaves, std::uint32_t seed, float gain) {
  return SumOctaves<Eigen::Vector2f>(p, octaves, seed, gain);
}

BrickCell BrickAt(const BrickPattern& pattern, const Eigen::Vector2f& uv, std::uint32_t seed) {
  BrickCell cell;
  const float y = uv.y() / pattern.course_height;
  cell.course = IntervalOf(y, pattern.height_jitter, seed);
  const float y0 = IntervalStart(cell.course, pattern.height_jitter, seed);
  const float y1 = IntervalStart(cell.course + 1, pattern.height_jitter, seed);
  const std::uint32_t course_seed = HashOf(cell.course, 5, 1, seed);
  const float shift = pattern.random_shift ? UnitOf(course_seed) * 13.7F
                                           : pattern.course_shift * static_cast<float>(cell.course);
  const float x = uv.x() / pattern.length + shift;
  const int column = IntervalOf(x, pattern.length_jitter, course_seed);
  const float x0 = IntervalStart(column, pattern.length_jitter, course_seed);
  const float x1 = IntervalStart(column + 1, pattern.length_jitter, course_seed);
  cell.hash = HashOf(column, cell.course, 9, seed);
  cell.u = (x - x0) * pattern.length;
  cell.v = (y - y0) * pattern.course_height;
  cell.edge_u = std::min(cell.u, (x1 - x) * pattern.length);
  cell.edge_v = std::min(cell.v, (y1 - y) * pattern.course_height);
  return cell;
}

PebbleCell PebbleAt(const Eigen::Vector2f& p, std::uint32_t seed) {
  const int x = FloorInt(p.x()), y = FloorInt(p.y());
  float nearest = std::numeric_limits<float>::max(), second = nearest;
  PebbleCell cell;
  for (int j = y - 1; j <= y + 1; ++j) {
    for (int i = x - 1; i <= x + 1; ++i) {
      const std::uint32_t hash = HashOf(i, j, 31, seed);
      const float cx =
          static_cast<float>(i) + 0.1F + 0.8F * 0x1p-16F * static_cast<float>(hash >> 16);
      const float cy =
          static_cast<float>(j) + 0.1F + 0.8F * 0x1p-16F * static_cast<float>(hash & 0xffffU);
      const float distance = (p.x() - cx) * (p.x() - cx) + (p.y() - cy) * (p.y() - cy);  // squared
      if (distance < nearest) {
        second = nearest;
        nearest = distance;
        cell.hash = hash;
      } else {
        second = std::min(second, distance);
      }
    }
  }
  cell.distance = std::sqrt(nearest);
  cell.edge = std::sqrt(second) - cell.distance;
  return cell;
}

}  // namespace colmap_ext
