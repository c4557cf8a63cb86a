#include <cmath>

#include "sim/noise.h"
#include "sim/painters.h"

namespace colmap_ext {

Painter GlazedTubes(std::uint32_t seed, float pitch_m) {
  return [=](const SurfacePoint& p) -> Rgb {
    const int tube = FloorInt(p.chart.x() / pitch_m + 0.5F);
    const float across = p.chart.x() / pitch_m - static_cast<float>(tube);  // -0.5 … 0.5
    const float length = 0.38F, shift = 0.1F * HashUnit(tube, 1, 2, seed + p.seed);
    const float along = p.chart.y() / length + shift;
    const int piece = FloorInt(along);
    const std::uint32_t hash = HashOf(tube, piece, 3, seed + p.seed);
    Rgb color = Blend(Rgb(0.22F, 0.27F, 0.25F), Rgb(0.42F, 0.46F, 0.38F), HashUnit(hash, 1));
    const float kind = HashUnit(hash, 2);
    if (kind < 0.07F) color = Rgb(0.46F, 0.37F, 0.25F);  // glaze gone
    if (kind > 0.94F) color = Rgb(0.16F, 0.30F, 0.27F);
    color *= 1 + 0.25F * Fbm(Eigen::Vector2f(p.chart * 9), 4, hash, 0.65F);
    const float patch = Fbm(Eigen::Vector3f(p.world * 0.9F), 4, seed + 4);
    color = Blend(color, Rgb(0.40F, 0.38F, 0.22F), 0.55F * SmoothStep(0.2F, 0.7F, patch));
    const float lichen = Fbm(Eigen::Vector3f(p.world * 5), 3, seed + 5);
    color = Blend(color, Rgb(0.68F, 0.68F, 0.56F), 0.6F * SmoothStep(0.52F, 0.62F, lichen));
    const float joint = (along - static_cast<float>(piece)) * length;
    color *= 0.45F + 0.55F * SmoothStep(0.0F, 0.03F, joint);
    // The channels between the tubes lie deeper and gather dirt.
    return color * (1 - 0.45F * SmoothStep(0.28F, 0.45F, std::abs(across)));
  };
}

Painter LacqueredWood(std::uint32_t seed, const Rgb& tone) {
  return [=](const SurfacePoint& p) -> Rgb {
    const Eigen::Vector3f w = p.world;
    Rgb color = tone * (1 + 0.14F * Fbm(Eigen::Vector3f(w * 0.8F), 3, seed));
    color *= 1 + 0.10F * Fbm(Eigen::Vector3f(w.x() * 18, w.y() * 18, w.z() * 1.2F), 3, seed + 1);
    // Flaked paint shows ground coat and grey wood.
    const float flake = Fbm(Eigen::Vector3f(w * 3.3F), 5, seed + 2, 0.62F);
    color = Blend(color, Rgb(0.62F, 0.42F, 0.30F), SmoothStep(0.36F, 0.42F, flake));
    color = Blend(color, Rgb(0.47F, 0.42F, 0.37F), SmoothStep(0.48F, 0.54F, flake));
    const float stain = Fbm(Eigen::Vector3f(w.x() * 5, w.y() * 5, w.z() * 0.6F), 4, seed + 3, 0.6F);
    color *= 1 - 0.42F * SmoothStep(0.1F, 0.6F, stain);
    const float chips = Fbm(Eigen::Vector3f(w * 11), 3, seed + 4);
    return Blend(color, Rgb(0.20F, 0.13F, 0.11F), 0.75F * SmoothStep(0.5F, 0.58F, chips));
  };
}

Painter PaintedBeam(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    static const Rgb kPalette[] = {{0.12F, 0.32F, 0.45F}, {0.13F, 0.42F, 0.33F},
                                   {0.62F, 0.20F, 0.13F}, {0.78F, 0.62F, 0.25F},
                                   {0.86F, 0.84F, 0.76F}, {0.10F, 0.20F, 0.33F}};
    const BrickPattern panel{0.24F, 0.36F, 0.1F, 0.35F, 0, true};
    const BrickCell cell = BrickAt(panel, p.chart, seed + p.seed);
    Rgb color = kPalette[cell.hash % 6];
    // A rosette of rings in each panel.
    const Eigen::Vector2f q(cell.u - 0.18F, cell.v - 0.12F);
    const float angle = std::atan2(q.y(), q.x());
    const float petals = 3 + static_cast<float>(cell.hash % 5);
    const float ring = q.norm() * (1 + 0.25F * std::cos(petals * angle)) / 0.03F;
    const int index = FloorInt(ring);
    if (index < 4) color = kPalette[HashOf(index, 0, 0, cell.hash) % 6];
    color = Blend(kPalette[3], color, SmoothStep(0.008F, 0.014F, cell.Edge()));
    color *= 1 + 0.2F * Fbm(Eigen::Vector3f(p.world * 4), 4, seed + 1, 0.6F);
    const float flake = Fbm(Eigen::Vector3f(p.world * 6), 4, seed + 2, 0.62F);
    return Blend(color, Rgb(0.45F, 0.38F, 0.31F), 0.85F * SmoothStep(0.42F, 0.50F, flake));
  };
}

Painter StuddedDoor(std::uint32_t seed) {
  const Painter wood = LacqueredWood(seed, Rgb(0.58F, 0.13F, 0.10F));
  return [seed, wood](const SurfacePoint& p) -> Rgb {
    Rgb color = wood(p);
    const float pitch = 0.30F;
    const Eigen::Vector2f q = p.chart / pitch;
    const int i = FloorInt(q.x()), j = FloorInt(q.y());
    const Eigen::Vector2f local =
        (q - Eigen::Vector2f(static_cast<float>(i) + 0.5F, static_cast<float>(j) + 0.5F)) * pitch;
    const std::uint32_t hash = HashOf(i, j, 2, seed + p.seed);
    const float radius = 0.060F + 0.02F * HashUnit(hash, 1);
    color *= 0.55F + 0.45F * SmoothStep(radius, radius * 1.4F, local.norm());
    const float lit = 0.75F + 4 * (local.y() - local.x());
    const Rgb brass = Rgb(0.74F, 0.58F, 0.24F) * (0.6F + 0.6F * HashUnit(hash, 2)) * lit;
    if (HashUnit(hash, 3) > 0.08F) {
      color = Blend(brass, color, SmoothStep(radius * 0.85F, radius, local.norm()));
    }
    const float seam = std::abs(p.chart.x() - p.size.x() / 2);
    return color * (0.25F + 0.75F * SmoothStep(0.008F, 0.02F, seam));
  };
}

}  // namespace colmap_ext
