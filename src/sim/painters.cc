#include "sim/painters.h"

#include <cmath>

#include "sim/noise.h"

namespace colmap_ext {
namespace {

// Streaks that rain leaves on walls: long in v, short in u.
float Streaks(const SurfacePoint& p, std::uint32_t seed) {
  const Eigen::Vector3f q(p.world.x() * 3.1F, p.world.y() * 3.1F, p.world.z() * 0.35F);
  return SmoothStep(0.15F, 0.7F, Fbm(q, 3, seed));
}

Rgb WeatherStone(const SurfacePoint& p, std::uint32_t seed, Rgb color) {
  color *= 1 + 0.16F * Fbm(Eigen::Vector3f(p.world * 0.45F), 2, seed + 1);
  color = Blend(color, Rgb(0.30F, 0.28F, 0.25F), 0.42F * Streaks(p, seed + 2));
  if (p.world.z() < 3.5F) {
    const float damp = Fbm(Eigen::Vector3f(p.world * 1.7F), 4, seed + 3);
    const float moss = SmoothStep(0.1F, 0.6F, damp + 0.55F - 0.5F * p.world.z());
    color = Blend(color, Rgb(0.28F, 0.33F, 0.17F), 0.6F * moss);
  }
  const float lichen = Fbm(Eigen::Vector3f(p.world * 5.3F), 3, seed + 4);
  color = Blend(color, Rgb(0.80F, 0.77F, 0.62F), 0.55F * SmoothStep(0.52F, 0.62F, lichen));
  color = Blend(color, Rgb(0.25F, 0.24F, 0.22F), 0.5F * SmoothStep(0.50F, 0.60F, -lichen));
  return color;
}

}  // namespace

Painter RubbleStone(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    static const Rgb kPalette[] = {{0.76F, 0.70F, 0.57F}, {0.68F, 0.61F, 0.49F},
                                   {0.62F, 0.59F, 0.54F}, {0.80F, 0.71F, 0.52F},
                                   {0.55F, 0.50F, 0.44F}, {0.70F, 0.57F, 0.44F}};
    const BrickPattern pattern{0.29F, 0.52F, 0.35F, 0.4F, 0, true};
    const Eigen::Vector2f wobble(Noise(Eigen::Vector2f(p.uv * 7), seed + 10),
                                 Noise(Eigen::Vector2f(p.uv * 7), seed + 11));
    const BrickCell cell = BrickAt(pattern, p.uv + 0.012F * wobble, seed);
    Rgb color = kPalette[cell.hash % 6] * (0.80F + 0.36F * HashUnit(cell.hash, 1));
    const Eigen::Vector2f grain = p.uv + Eigen::Vector2f(HashUnit(cell.hash, 2) * 50, 0);
    color *= 1 + 0.22F * Fbm(Eigen::Vector2f(grain * 9), 4, seed + 12, 0.65F);
    color *= 1 + 0.10F * Noise(Eigen::Vector2f(p.uv * 55), seed + 13);
    // Rounded arrises: light from above, dark below.
    const float rim = 1 - SmoothStep(0.01F, 0.05F, cell.Edge());
    color *= 1 - 0.22F * rim + (cell.v > 0.15F ? 0.10F : -0.06F) * rim;
    const float mortar = 1 - SmoothStep(0.006F, 0.016F, cell.Edge());
    const Rgb lime(0.56F, 0.53F, 0.47F);
    color = Blend(color, lime * (0.9F + 0.2F * Noise(Eigen::Vector2f(p.uv * 30), seed + 14)),
                  0.85F * mortar);
    return WeatherStone(p, seed + 20, color);
  };
}

Painter DressedStone(std::uint32_t seed, const Rgb& tone) {
  return [seed, tone](const SurfacePoint& p) -> Rgb {
    const BrickPattern pattern{0.42F, 0.7F, 0.15F, 0.3F, 0, true};
    const BrickCell cell = BrickAt(pattern, p.uv, seed);
    Rgb color = tone * (0.86F + 0.26F * HashUnit(cell.hash, 1));
    color.z() *= 0.94F + 0.12F * HashUnit(cell.hash, 2);
    color *= 1 + 0.16F * Fbm(Eigen::Vector3f(p.world * 6), 4, seed + 1, 0.65F);
    // Marks of the chisel.
    color *=
        1 + 0.07F * Noise(Eigen::Vector2f(p.uv.x() * 60 + p.uv.y() * 25, p.uv.y() * 8), seed + 2);
    color = Blend(color, tone * 0.55F, 0.7F * (1 - SmoothStep(0.003F, 0.010F, cell.Edge())));
    return WeatherStone(p, seed + 20, color);
  };
}

Painter RoofTiles(std::uint32_t seed, float course_m, const Rgb& dark, const Rgb& light) {
  return [=](const SurfacePoint& p) -> Rgb {
    const BrickPattern pattern{course_m, 0.24F, 0, 0.06F, 0.5F, false};
    const std::uint32_t slope = seed + p.seed;
    const BrickCell cell = BrickAt(pattern, p.chart, slope);
    const float patch = Fbm(Eigen::Vector3f(p.world * 0.5F), 3, seed + 1);
    Rgb color = Blend(dark, light, std::clamp(HashUnit(cell.hash, 1) + 0.35F * patch, 0.F, 1.F));
    const float kind = HashUnit(cell.hash, 2);
    if (kind < 0.06F) color = Blend(color, Rgb(0.22F, 0.17F, 0.16F), 0.7F);   // burnt
    if (kind > 0.95F) color = Blend(color, Rgb(0.78F, 0.55F, 0.40F), 0.65F);  // new
    color *= 1 + 0.24F * Fbm(Eigen::Vector2f(p.chart * 11), 4, slope + 2, 0.65F);
    color *= 1 + 0.10F * Noise(Eigen::Vector2f(p.chart * 60), slope + 3);
    const float moss = Fbm(Eigen::Vector3f(p.world * 1.3F), 4, seed + 4);
    color = Blend(color, Rgb(0.33F, 0.34F, 0.18F), 0.55F * SmoothStep(0.25F, 0.7F, moss));
    const float lichen = Fbm(Eigen::Vector3f(p.world * 6.1F), 3, seed + 5);
    color = Blend(color, Rgb(0.72F, 0.68F, 0.52F), 0.6F * SmoothStep(0.55F, 0.65F, lichen));
    // Gaps beside the tile, its lower edge, and the shade of the course above.
    color *= 0.35F + 0.65F * SmoothStep(0.004F, 0.014F, cell.edge_u);
    color *= 0.60F + 0.40F * SmoothStep(0.0F, 0.03F, cell.v);
    color *= 0.70F + 0.30F * SmoothStep(0.0F, 0.06F, course_m - cell.v);
    return color;
  };
}

Painter Planks(std::uint32_t seed, float width_m, const Rgb& tone, bool along_u) {
  return [=](const SurfacePoint& p) -> Rgb {
    const Eigen::Vector2f along = along_u ? p.chart : Eigen::Vector2f(p.chart.y(), p.chart.x());
    const BrickPattern pattern{width_m, 1.7F, 0.1F, 0.4F, 0, true};
    const BrickCell cell = BrickAt(pattern, along, seed + p.seed);
    Rgb color = tone * (0.72F + 0.5F * HashUnit(cell.hash, 1));
    const float shift = 40 * HashUnit(cell.hash, 2);
    const float warp = 0.05F * Noise(Eigen::Vector2f(along.x() * 2, along.y() * 6), seed + 1);
    const float rings = Fbm(
        Eigen::Vector2f(along.x() * 1.6F + shift, (along.y() + warp) * 45 + shift), 3, seed + 2);
    color *= 1 + 0.34F * rings;
    const PebbleCell knot = PebbleAt({along.x() * 1.1F + shift, along.y() * 5}, seed + 3);
    if (HashUnit(knot.hash, 4) < 0.3F) {
      color *= 0.45F + 0.55F * SmoothStep(0.05F, 0.16F, knot.distance);
    }
    color *= 1 + 0.2F * Fbm(Eigen::Vector3f(p.world * 2.7F), 3, seed + 5);
    color *= 0.3F + 0.7F * SmoothStep(0.002F, 0.010F, cell.Edge());
    // A nail near either end of a plank.
    const float nail = std::hypot(cell.edge_u - 0.05F, cell.edge_v - width_m * 0.3F);
    return color * (0.35F + 0.65F * SmoothStep(0.006F, 0.014F, nail));
  };
}

Painter LeadedGlass(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    static const Rgb kPalette[] = {{0.10F, 0.16F, 0.34F}, {0.36F, 0.08F, 0.08F},
                                   {0.10F, 0.28F, 0.16F}, {0.46F, 0.36F, 0.10F},
                                   {0.16F, 0.22F, 0.26F}, {0.24F, 0.30F, 0.34F}};
    const float pane = 0.17F;
    const Eigen::Vector2f turned((p.chart.x() + p.chart.y() * 0.7F) / pane,
                                 (p.chart.x() - p.chart.y() * 0.7F) / pane);
    const int i = FloorInt(turned.x()), j = FloorInt(turned.y());
    const std::uint32_t hash = HashOf(i, j, 3, seed + p.seed);
    Rgb color = kPalette[hash % 6] * (0.6F + 0.9F * HashUnit(hash, 1));
    color *= 1 + 0.4F * Noise(Eigen::Vector2f(p.chart * 14), hash);
    const float fx = turned.x() - static_cast<float>(i), fy = turned.y() - static_cast<float>(j);
    const float edge = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy)) * pane;
    return Blend(Rgb(0.13F, 0.13F, 0.13F), color, SmoothStep(0.010F, 0.020F, edge));
  };
}

Painter Iron(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    const float rust = SmoothStep(0.0F, 0.5F, Fbm(Eigen::Vector3f(p.world * 9), 4, seed));
    const Rgb color = Blend(Rgb(0.20F, 0.20F, 0.21F), Rgb(0.42F, 0.24F, 0.14F), rust);
    return color * (1 + 0.25F * Noise(Eigen::Vector3f(p.world * 40), seed + 1));
  };
}

float PseudoText(const Eigen::Vector2f& uv, float height_m, std::uint32_t seed) {
  const float line_height = height_m * 1.6F, advance = height_m * 0.8F;
  const int line = FloorInt(uv.y() / line_height);
  const float y = (uv.y() - static_cast<float>(line) * line_height) / height_m;
  if (y > 1) return 0;
  const float u = uv.x() + 5 * HashUnit(line, 3, 8, seed);
  const int letter = FloorInt(u / advance);
  const float x = (u - static_cast<float>(letter) * advance) / (advance * 0.8F);
  const std::uint32_t hash = HashOf(letter, line, 77, seed);
  if (x > 1 || HashUnit(hash, 1) < 0.16F) return 0;  // a gap between letters or words
  const int column = FloorInt(x * 4), row = FloorInt(y * 5);
  return HashUnit(HashOf(column, row, 1, hash), 2) < 0.52F ? 1.0F : 0.0F;
}

}  // namespace colmap_ext
