#include <cmath>

#include "sim/noise.h"
#include "sim/painters.h"

namespace colmap_ext {
namespace {

const Rgb kInks[] = {{0.12F, 0.12F, 0.13F}, {0.60F, 0.13F, 0.10F}, {0.10F, 0.25F, 0.52F},
                     {0.10F, 0.40F, 0.22F}, {0.82F, 0.60F, 0.12F}, {0.88F, 0.87F, 0.82F}};

Rgb Kraft(const SurfacePoint& p, std::uint32_t seed) {
  Rgb color(0.70F, 0.54F, 0.36F);
  color *= 0.88F + 0.2F * HashUnit(p.seed, 1);
  color *= 1 + 0.16F * Fbm(Eigen::Vector2f(p.chart * 2.1F), 4, seed + p.seed);
  color *= 1 + 0.05F * std::sin(p.chart.x() * 2 * 3.14159F / 0.008F);  // the corrugation
  const float fibres =
      Fbm(Eigen::Vector2f(p.chart.x() * 220, p.chart.y() * 60), 3, seed + 1 + p.seed);
  color *= 1 + 0.13F * fibres;
  const float stain = Fbm(Eigen::Vector2f(p.chart * 6), 5, seed + 2 + p.seed, 0.6F);
  color *= 1 - 0.4F * SmoothStep(0.30F, 0.40F, stain);
  const float scratch =
      Fbm(Eigen::Vector2f(p.chart.x() * 9 + p.chart.y() * 5, p.chart.y() * 60), 3, seed + 3);
  return Blend(color, Rgb(0.86F, 0.77F, 0.62F), 0.6F * SmoothStep(0.55F, 0.62F, scratch));
}

// A printed window: panes of random tone in a frame.
Rgb PrintedWindow(const BrickCell& cell, const Rgb& paper, const Rgb& ink) {
  const float margin = 0.025F;
  if (cell.edge_u < margin || cell.edge_v < margin) return paper;
  if (cell.edge_u < margin + 0.010F || cell.edge_v < margin + 0.010F) return ink;
  const int i = FloorInt(cell.u / 0.045F), j = FloorInt(cell.v / 0.05F);
  const std::uint32_t pane = HashOf(i, j, 4, cell.hash);
  const Rgb color = Blend(ink, paper, HashUnit(pane, 1));
  return HashUnit(pane, 2) < 0.25F ? Blend(color, kInks[pane % 6], 0.7F) : color;
}

Rgb PrintedLabel(const Eigen::Vector2f& at, std::uint32_t hash, const Rgb& paper) {
  const float style = HashUnit(hash, 5);
  const Rgb ink = kInks[hash % 4];
  if (style < 0.4F) {
    return Blend(paper, ink, 0.9F * PseudoText(at, 0.02F + 0.05F * HashUnit(hash, 6), hash));
  }
  if (style < 0.6F) {  // bar code
    return HashUnit(FloorInt(at.x() / 0.006F), 0, 1, hash) < 0.5F ? Rgb(0.9F, 0.9F, 0.88F) : ink;
  }
  const float art = Fbm(Eigen::Vector2f(at * 14), 4, hash, 0.6F);  // a picture
  const Rgb ground = Blend(kInks[(hash >> 4) % 6], Rgb(0.9F, 0.88F, 0.8F), 0.4F);
  return Blend(ground, kInks[(hash >> 8) % 6], SmoothStep(-0.08F, 0.08F, art));
}

}  // namespace

Painter Cardboard(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    Rgb color = Kraft(p, seed);
    // Windows in storeys, labels in between.
    const BrickPattern storeys{
        0.22F + 0.1F * HashUnit(p.seed, 2), 0.2F + 0.1F * HashUnit(p.seed, 3), 0.1F, 0.3F, 0, true};
    const BrickCell cell = BrickAt(storeys, p.chart, seed + p.seed);
    const float kind = HashUnit(cell.hash, 9);
    const Rgb ink = Blend(kInks[p.seed % 4], color, 0.15F);
    const bool inside =
        (p.chart.array() > 0.02F).all() && (p.chart.array() < p.size.array() - 0.02F).all();
    if (inside && kind < 0.55F) {
      color = PrintedWindow(cell, color, ink);
    } else if (inside && kind < 0.85F && cell.Edge() > 0.02F) {
      color = PrintedLabel({cell.u, cell.v}, cell.hash, color);
    }
    // Packing tape down the middle.
    const float tape = std::abs(p.chart.x() - p.size.x() * (0.3F + 0.4F * HashUnit(p.seed, 4)));
    if (tape < 0.026F && HashUnit(p.seed, 5) < 0.6F) {
      const float crease = Fbm(Eigen::Vector2f(p.chart * 25), 3, seed + 8 + p.seed);
      color = Blend(color, Rgb(0.80F, 0.72F, 0.52F) * (1 + 0.25F * crease), 0.75F);
    }
    return color * (1 + 0.06F * Noise(Eigen::Vector2f(p.chart * 160), seed + 9));
  };
}

Painter Parquet(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    // Square fields of staves, every second one turned.
    const float field = 0.42F;
    const int i = FloorInt(p.world.x() / field), j = FloorInt(p.world.y() / field);
    Eigen::Vector2f at(p.world.x() - static_cast<float>(i) * field,
                       p.world.y() - static_cast<float>(j) * field);
    if (((i + j) & 1) != 0) at = {at.y(), at.x()};
    const int stave = FloorInt(at.y() / 0.07F);
    const std::uint32_t hash = HashOf(i * 7 + stave, j, stave, seed);
    Rgb color = Blend(Rgb(0.36F, 0.22F, 0.13F), Rgb(0.68F, 0.50F, 0.31F), HashUnit(hash, 1));
    color *= 1 + 0.3F * Fbm(Eigen::Vector2f(at.x() * 5, at.y() * 90), 3, hash);
    const float seam = std::min(at.y() - 0.07F * static_cast<float>(stave), at.x());
    color *= 0.4F + 0.6F * SmoothStep(0.001F, 0.005F, seam);
    color *= 1 + 0.14F * Fbm(Eigen::Vector3f(p.world * 1.1F), 4, seed + 1);
    const float scuff =
        Fbm(Eigen::Vector2f(p.world.x() * 3 + p.world.y(), p.world.y() * 14), 4, seed + 2, 0.6F);
    color = Blend(color, Rgb(0.74F, 0.64F, 0.50F), 0.5F * SmoothStep(0.42F, 0.5F, scuff));
    const PebbleCell spot = PebbleAt(Eigen::Vector2f(p.world.head<2>() * 1.8F), seed + 3);
    if (HashUnit(spot.hash, 1) < 0.5F) {  // paint drops
      const float radius = 0.03F + 0.07F * HashUnit(spot.hash, 2);
      color = Blend(kInks[spot.hash % 6], color, SmoothStep(radius * 0.8F, radius, spot.distance));
    }
    return color;
  };
}

Painter PosteredWall(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    Rgb color(0.80F, 0.78F, 0.73F);
    color *= 1 + 0.07F * Fbm(Eigen::Vector2f(p.chart * 1.3F), 4, seed + p.seed);
    color *= 1 + 0.06F * Fbm(Eigen::Vector2f(p.chart * 40), 3, seed + 1 + p.seed);
    const float mark = Fbm(Eigen::Vector2f(p.chart * 7), 4, seed + 2 + p.seed, 0.6F);
    color *= 1 - 0.35F * SmoothStep(0.42F, 0.5F, mark);
    const BrickPattern grid{0.8F, 0.7F, 0.25F, 0.35F, 0, true};
    const BrickCell cell = BrickAt(grid, p.chart, seed + p.seed);
    const float margin = 0.05F + 0.09F * HashUnit(cell.hash, 1);
    if (HashUnit(cell.hash, 2) < 0.7F && cell.Edge() > margin) {
      const Rgb sheet =
          Blend(kInks[cell.hash % 6], Rgb(0.93F, 0.92F, 0.87F), HashUnit(cell.hash, 3));
      color = cell.Edge() < margin + 0.012F ? kInks[(cell.hash >> 6) % 6]
                                            : PrintedLabel({cell.u, cell.v}, cell.hash, sheet);
    }
    return color;
  };
}

}  // namespace colmap_ext
