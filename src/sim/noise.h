// Hashed noise and cell patterns from which the procedural textures are made. Pure functions of
// their arguments: the same pictures on every machine and in any order.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

namespace colmap_ext {

constexpr std::uint32_t HashBits(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352dU;
  h ^= h >> 15;
  h *= 0x846ca68bU;
  h ^= h >> 16;
  return h;
}

inline std::uint32_t HashOf(int x, int y, int z, std::uint32_t seed) {
  return HashBits(static_cast<std::uint32_t>(x) * 0x9e3779b1U ^
                  static_cast<std::uint32_t>(y) * 0x85ebca6bU ^
                  static_cast<std::uint32_t>(z) * 0xc2b2ae35U ^ seed * 0x27d4eb2fU);
}

// 0 … 1
inline float UnitOf(std::uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24F; }
inline float HashUnit(int x, int y, int z, std::uint32_t seed) {
  return UnitOf(HashOf(x, y, z, seed));
}
// A further independent number from the same hash.
inline float HashUnit(std::uint32_t hash, std::uint32_t salt) {
  return UnitOf(HashBits(hash + salt * 0x9e3779b1U));
}

inline int FloorInt(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (static_cast<float>(truncated) > value ? 1 : 0);
}

inline float SmoothStep(float low, float high, float value) {
  const float t = std::min(1.0F, std::max(0.0F, (value - low) / (high - low)));
  return t * t * (3 - 2 * t);
}

// Smooth noise with unit cells, -1 … 1.
float Noise(const Eigen::Vector3f& p, std::uint32_t seed);
float Noise(const Eigen::Vector2f& p, std::uint32_t seed);

// Sum of octaves at doubling frequency and falling amplitude, about -1 … 1.
float Fbm(const Eigen::Vector3f& p, int octaves, std::uint32_t seed, float gain = 0.5F);
float Fbm(const Eigen::Vector2f& p, int octaves, std::uint32_t seed, float gain = 0.5F);

// Which brick of a wall in courses a point is in.
struct BrickPattern {
  float course_height = 0.3F;  // m
  float length = 0.5F;         // m
  float height_jitter = 0;     // of the course height, 0 … 0.4
  float length_jitter = 0;     // of the length, 0 … 0.4
  float course_shift = 0.5F;   // of the length, from course to course
  bool random_shift = false;   // instead of course_shift
};
struct BrickCell {
  int course = 0;
  std::uint32_t hash = 0;  // of the brick
  float edge_u = 0;        // m to the nearer vertical joint
  float edge_v = 0;        // m to the nearer bed joint
  float u = 0, v = 0;      // m from the brick's lower left corner
  float Edge() const { return std::min(edge_u, edge_v); }
};
BrickCell BrickAt(const BrickPattern& pattern, const Eigen::Vector2f& uv, std::uint32_t seed);

// Voronoi cell of jittered unit cells.
struct PebbleCell {
  std::uint32_t hash = 0;
  float distance = 0;  // to the cell's centre
  float edge = 0;      // second nearest centre minus nearest: 0 at the border
};
PebbleCell PebbleAt(const Eigen::Vector2f& p, std::uint32_t seed);

}  // namespace colmap_ext
