#include "sim/noise.h"

#include <cmath>
#include <limits>

namespace colmap_ext {
namespace {

float Fade(float t) { return t * t * (3 - 2 * t); }
float Mix(float a, float b, float t) { return a + (b - a) * t; }

// The three products of a lattice point's hash are shared by the corners of a cell, and the
// finishing is light: textures evaluate this some 10^9 times.
constexpr std::uint32_t kPrimeX = 0x9e3779b1U, kPrimeY = 0x85ebca6bU, kPrimeZ = 0xc2b2ae35U;
float Signed(std::uint32_t mixed) {
  mixed ^= mixed >> 15;
  mixed *= 0x2c1b3c6dU;
  mixed ^= mixed >> 13;
  mixed *= 0x297a2d39U;
  return static_cast<float>(static_cast<std::int32_t>(mixed)) * 0x1p-31F;
}

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
  const int x = FloorInt(p.x()), y = FloorInt(p.y());
  const float tx = Fade(p.x() - static_cast<float>(x)), ty = Fade(p.y() - static_cast<float>(y));
  const std::uint32_t x0 = static_cast<std::uint32_t>(x) * kPrimeX ^ seed * 0x27d4eb2fU;
  const std::uint32_t x1 = (static_cast<std::uint32_t>(x) + 1) * kPrimeX ^ seed * 0x27d4eb2fU;
  const std::uint32_t y0 = static_cast<std::uint32_t>(y) * kPrimeY, y1 = y0 + kPrimeY;
  return Mix(Mix(Signed(x0 ^ y0), Signed(x1 ^ y0), tx), Mix(Signed(x0 ^ y1), Signed(x1 ^ y1), tx),
             ty);
}

float Noise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const int x = FloorInt(p.x()), y = FloorInt(p.y()), z = FloorInt(p.z());
  const float tx = Fade(p.x() - static_cast<float>(x)), ty = Fade(p.y() - static_cast<float>(y));
  const float tz = Fade(p.z() - static_cast<float>(z));
  const std::uint32_t x0 = static_cast<std::uint32_t>(x) * kPrimeX ^ seed * 0x27d4eb2fU;
  const std::uint32_t x1 = (static_cast<std::uint32_t>(x) + 1) * kPrimeX ^ seed * 0x27d4eb2fU;
  const std::uint32_t y0 = static_cast<std::uint32_t>(y) * kPrimeY, y1 = y0 + kPrimeY;
  const std::uint32_t z0 = static_cast<std::uint32_t>(z) * kPrimeZ, z1 = z0 + kPrimeZ;
  const auto layer = [&](std::uint32_t k) {
    return Mix(Mix(Signed(x0 ^ y0 ^ k), Signed(x1 ^ y0 ^ k), tx),
               Mix(Signed(x0 ^ y1 ^ k), Signed(x1 ^ y1 ^ k), tx), ty);
  };
  return Mix(layer(z0), layer(z1), tz);
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
