#include <cmath>

#include "sim/noise.h"
#include "sim/painters.h"

namespace colmap_ext {
namespace {

Rgb Grass(const Eigen::Vector2f& xy, std::uint32_t seed) {
  const float large = Fbm(Eigen::Vector2f(xy * 0.16F), 3, seed);
  const float middle = Fbm(Eigen::Vector2f(xy * 0.9F), 3, seed + 1);
  const float clumps = Fbm(Eigen::Vector2f(xy * 4.5F), 4, seed + 2, 0.7F);
  Rgb color(0.36F, 0.41F, 0.22F);
  color = Blend(color, Rgb(0.52F, 0.50F, 0.27F), 0.55F * SmoothStep(-0.1F, 0.7F, large));
  color = Blend(color, Rgb(0.26F, 0.33F, 0.17F), 0.6F * SmoothStep(0.0F, 0.6F, middle));
  color *= 1 + 0.42F * clumps;
  color *= 1 + 0.30F * Noise(Eigen::Vector2f(xy.x() * 36, xy.y() * 21), seed + 3);
  // Bare earth shows through here and there.
  const float bare = Fbm(Eigen::Vector2f(xy * 0.55F), 5, seed + 4, 0.6F);
  const Rgb earth =
      Rgb(0.45F, 0.36F, 0.26F) * (1 + 0.3F * Fbm(Eigen::Vector2f(xy * 7), 4, seed + 5, 0.65F));
  color = Blend(color, earth, SmoothStep(0.38F, 0.55F, bare));
  return color;
}

// Flowers, fallen leaves and stones lying in the grass.
Rgb Litter(const Eigen::Vector2f& xy, std::uint32_t seed, Rgb color) {
  static const Rgb kPalette[] = {{0.93F, 0.92F, 0.86F}, {0.88F, 0.76F, 0.20F},
                                 {0.47F, 0.27F, 0.12F}, {0.62F, 0.40F, 0.16F},
                                 {0.62F, 0.60F, 0.57F}, {0.30F, 0.20F, 0.12F}};
  const PebbleCell small = PebbleAt(Eigen::Vector2f(xy * 2.6F), seed);
  const float density = 0.30F + 0.25F * Noise(Eigen::Vector2f(xy * 0.3F), seed + 1);
  if (HashUnit(small.hash, 3) < density) {
    const float radius = 0.05F + 0.10F * HashUnit(small.hash, 4);
    const float inside = 1 - SmoothStep(radius * 0.75F, radius, small.distance);
    color = Blend(color, kPalette[small.hash % 6], 0.9F * inside);
  }
  const PebbleCell stone = PebbleAt(Eigen::Vector2f(xy * 0.55F), seed + 2);
  if (HashUnit(stone.hash, 3) < 0.35F) {
    const float bumpy = stone.distance + 0.04F * Noise(Eigen::Vector2f(xy * 9), seed + 3);
    const float radius = 0.05F + 0.11F * HashUnit(stone.hash, 4);
    const Rgb grey = Rgb(0.56F, 0.54F, 0.50F) * (0.75F + 0.5F * HashUnit(stone.hash, 5)) *
                     (1 + 0.3F * Fbm(Eigen::Vector2f(xy * 14), 3, seed + 4));
    color *= 1 - 0.35F * (1 - SmoothStep(radius, radius * 1.35F, bumpy));
    color = Blend(color, grey, 1 - SmoothStep(radius * 0.9F, radius, bumpy));
  }
  return color;
}

Rgb Gravel(const Eigen::Vector2f& xy, std::uint32_t seed) {
  const PebbleCell coarse = PebbleAt(Eigen::Vector2f(xy * 9), seed);
  const PebbleCell fine = PebbleAt(Eigen::Vector2f(xy * 26), seed + 1);
  const float tone =
      0.62F + 0.5F * (HashUnit(coarse.hash, 1) - 0.5F) + 0.3F * (HashUnit(fine.hash, 1) - 0.5F);
  Rgb color = Rgb(0.98F, 0.93F, 0.84F) * tone;
  color *= 0.65F + 0.35F * SmoothStep(0.02F, 0.16F, coarse.edge);
  color *= 1 + 0.16F * Fbm(Eigen::Vector2f(xy * 0.7F), 3, seed + 2);
  return color;
}

Rgb Paving(const Eigen::Vector2f& xy, std::uint32_t seed) {
  const BrickPattern pattern{0.62F, 0.85F, 0.3F, 0.35F, 0, true};
  const BrickCell cell = BrickAt(pattern, xy, seed);
  Rgb color = Rgb(0.58F, 0.56F, 0.52F) * (0.72F + 0.5F * HashUnit(cell.hash, 1));
  color.z() *= 0.92F + 0.16F * HashUnit(cell.hash, 2);
  color *=
      1 +
      0.24F * Fbm(Eigen::Vector2f(xy * 5 + Eigen::Vector2f::Constant(30 * HashUnit(cell.hash, 3))),
                  5, seed + 1, 0.65F);
  const float joint = 1 - SmoothStep(0.012F, 0.026F, cell.Edge());
  return Blend(color, Rgb(0.26F, 0.29F, 0.17F), 0.8F * joint);
}

}  // namespace

Painter Meadow(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    const Eigen::Vector2f xy = p.world.head<2>();
    return Litter(xy, seed + 50, Grass(xy, seed));
  };
}

Painter Ground(std::uint32_t seed, const GroundMasks& masks) {
  return [seed, masks](const SurfacePoint& p) -> Rgb {
    const Eigen::Vector2f xy = p.world.head<2>();
    const float ragged = 0.35F * Fbm(Eigen::Vector2f(xy * 1.9F), 4, seed + 1);
    const float paving = SmoothStep(0.45F, 0.55F, masks.paving(xy) + 0.25F * ragged);
    if (paving >= 1) return Paving(xy, seed + 200);
    const float gravel = SmoothStep(0.40F, 0.60F, masks.gravel(xy) + ragged);
    Rgb color = gravel >= 1 ? Rgb::Zero() : Litter(xy, seed + 50, Grass(xy, seed));
    if (gravel > 0) color = Blend(color, Gravel(xy, seed + 100), gravel);
    return paving > 0 ? Blend(color, Paving(xy, seed + 200), paving) : color;
  };
}

}  // namespace colmap_ext
