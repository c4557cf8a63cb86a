// The Asian gate: three bays of columns and doors on a platform, brackets, and two tiers of curved
// roofs whose eaves hide what is below them. Local x along the front, which faces south.
#include <algorithm>
#include <cmath>

#include "sim/building_parts.h"
#include "sim/noise.h"
#include "sim/painters.h"
#include "sim/scenes.h"

namespace colmap_ext {
namespace {

enum Part { kPlatform = 1, kHall = 2, kLowerRoof = 3, kUpperHall = 4, kUpperRoof = 5 };

struct GateMaterials {
  int granite = 0, column = 0, beam = 0, wood = 0, tiles = 0, ridge = 0, door = 0, plaster = 0,
      plaque = 0;
};

constexpr double kTubePitch = 0.42;  // m
constexpr double kFloor = 0.9;       // m, top of the platform
constexpr double kColumnsX[] = {-5.6, -2.1, 2.1, 5.6};
constexpr double kColumnsY[] = {-2.3, 0.0, 2.3};

// Hip roof over a rectangle, concave, with corners that turn up.
struct CurvedRoof {
  double eave_x, eave_y;  // m, half extents at the eave
  double top_x, top_y;    // m, half extents at the top
  double eave_z, rise;    // m
  double wall_y;          // m, half depth of the walls below
};
constexpr CurvedRoof kLower{9.2, 5.6, 5.0, 1.7, 6.3, 2.9, 2.3};
constexpr CurvedRoof kUpper{7.6, 4.4, 3.6, 0.0, 10.7, 3.5, 1.5};

Painter Plaque(std::uint32_t seed) {
  return [seed](const SurfacePoint& p) -> Rgb {
    const Rgb gold(0.85F, 0.68F, 0.28F), blue(0.08F, 0.14F, 0.30F);
    const float rim = std::min(p.chart.minCoeff(), (p.size - p.chart).minCoeff());
    if (rim < 0.08F) return gold * (0.8F + 0.3F * Noise(Eigen::Vector2f(p.chart * 20), seed));
    const float ink = PseudoText(p.chart - Eigen::Vector2f::Constant(0.14F), 0.42F, seed + p.seed);
    return Blend(blue, gold, ink) * (1 + 0.2F * Fbm(Eigen::Vector2f(p.chart * 8), 4, seed));
  };
}

GateMaterials AddGateMaterials(std::uint32_t seed, SceneBuilder* builder) {
  GateMaterials m;
  m.granite =
      builder->AddMaterial("granite", 0.0125, DressedStone(seed + 1, Rgb(0.66F, 0.64F, 0.61F)));
  m.column = builder->AddMaterial("red_lacquer", 0.0125,
                                  LacqueredWood(seed + 2, Rgb(0.64F, 0.17F, 0.11F)));
  m.beam = builder->AddMaterial("painted_beams", 0.0125, PaintedBeam(seed + 3));
  m.wood = builder->AddMaterial("planks", 0.0125,
                                Planks(seed + 4, 0.2F, Rgb(0.46F, 0.25F, 0.17F), false));
  m.tiles = builder->AddMaterial("glazed_tiles", 0.0125,
                                 GlazedTubes(seed + 5, static_cast<float>(kTubePitch)));
  m.ridge =
      builder->AddMaterial("ridge_stone", 0.0125, DressedStone(seed + 6, Rgb(0.45F, 0.47F, 0.44F)));
  m.door = builder->AddMaterial("doors", 0.0125, StuddedDoor(seed + 7));
  m.plaster =
      builder->AddMaterial("plaster", 0.0125, LacqueredWood(seed + 8, Rgb(0.86F, 0.80F, 0.70F)));
  m.plaque = builder->AddMaterial("plaque", 0.008, Plaque(seed + 9));
  return m;
}

// One of four sides of a roof, in coordinates where it looks south.
class RoofSide {
 public:
  RoofSide(const CurvedRoof& roof, bool front)
      : a_(front ? roof.eave_x : roof.eave_y),
        b_(front ? roof.eave_y : roof.eave_x),
        top_a_(front ? roof.top_x : roof.top_y),
        top_b_(front ? roof.top_y : roof.top_x),
        roof_(roof) {}

  double eave_half() const { return a_; }
  double HalfAt(double t) const { return a_ + (top_a_ - a_) * t; }
  double Length() const { return std::hypot(b_ - top_b_, roof_.rise); }
  // s in [-1, 1] along the side, t in [0, 1] from eave to top; `below` the roof's middle surface.
  Eigen::Vector3d At(double s, double t, double below = 0) const {
    const double corner = std::pow(std::abs(s), 5) * (1 - t) * (1 - t);
    const double depth = (b_ + (top_b_ - b_) * t) * (1 + 0.03 * corner);
    return {s * HalfAt(t) * (1 + 0.03 * corner), -depth,
            roof_.eave_z + roof_.rise * (0.55 * t + 0.45 * t * t) + 0.85 * corner - below};
  }
  Eigen::Vector3d TubeTop(double s, double t) const {
    const double u = a_ + s * HalfAt(t);
    return At(s, t) + Eigen::Vector3d(0, -0.02, 0.05 + 0.05 * std::cos(2 * M_PI * u / kTubePitch));
  }

 private:
  double a_, b_, top_a_, top_b_;
  const CurvedRoof& roof_;
};

void AddRoofSide(const GateMaterials& m, const RoofSide& side, double wall_t,
                 SceneBuilder* builder) {
  const double thickness = 0.24, half = side.eave_half();
  const int nu = static_cast<int>(std::ceil(2 * half / kTubePitch)) * 6;
  const auto chart_at = [&](double s, double t) -> Eigen::Vector2d {
    return {half + (2 * s - 1) * side.HalfAt(t), t * side.Length()};
  };
  builder->AddGrid(
      m.tiles, nu, 14, {2 * half, side.Length()},
      [&](double s, double t) { return side.TubeTop(2 * s - 1, t); }, chart_at);
  // Seen from below, hence from right to left.
  builder->AddGrid(
      m.wood, 28, 8, {2 * half, side.Length()},
      [&](double s, double t) { return side.At(1 - 2 * s, t, thickness); }, chart_at);
  builder->AddGrid(
      m.tiles, nu, 1, {2 * half, thickness},
      [&](double s, double t) -> Eigen::Vector3d {
        return (1 - t) * side.At(2 * s - 1, 0, thickness) + t * side.TubeTop(2 * s - 1, 0);
      },
      [&](double s, double t) -> Eigen::Vector2d {
        return {2 * half * s, thickness * t};
      });
  // Rafters run straight up the slope until they meet the wall or the hip.
  const int rafters = static_cast<int>(2 * half / 0.46);
  for (int i = 1; i < rafters; ++i) {
    const double x = half * (2.0 * i / rafters - 1);
    const double hip_t = (half - std::abs(x)) / std::max(half - side.HalfAt(1), 1e-9);
    const double end = std::min(wall_t, hip_t - 0.02);
    if (end < 0.1) continue;
    builder->AddBar(m.column, side.At(x / side.HalfAt(0.02), 0.02, thickness + 0.06),
                    side.At(x / side.HalfAt(end), end, thickness + 0.06), 0.11, 0.13);
  }
  for (int k = 0; k < 9; ++k) {  // the ridge on the hip
    builder->AddBar(m.ridge, side.TubeTop(1, k / 9.0) + Eigen::Vector3d(0, 0, 0.08),
                    side.TubeTop(1, (k + 1.05) / 9.0) + Eigen::Vector3d(0, 0, 0.08), 0.30, 0.34);
  }
  builder->AddTurned(m.ridge, side.TubeTop(1, 0.03) + Eigen::Vector3d(0, 0, 0.2),
                     {{0.16, 0}, {0.20, 0.18}, {0.10, 0.34}, {0.15, 0.48}, {0, 0.62}}, 10);
}

void AddRoof(const GateMaterials& m, const CurvedRoof& roof, SceneBuilder* builder) {
  for (int k = 0; k < 4; ++k) {
    const RoofSide side(roof, k % 2 == 0);
    const double wall_t = (roof.eave_y - roof.wall_y - 0.4) / (roof.eave_y - roof.top_y);
    builder->SetPlacement(
        Eigen::Isometry3d(Eigen::AngleAxisd(k * M_PI / 2, Eigen::Vector3d::UnitZ())));
    AddRoofSide(m, side, wall_t, builder);
  }
  builder->SetPlacement(Eigen::Isometry3d::Identity());
}

// A stack of crossed arms that grows upwards and outwards (dougong).
void AddBracket(int material, const Eigen::Vector3d& foot, double height, SceneBuilder* builder) {
  const double step = height / 5;
  double z = foot.z();
  builder->AddBlock(material, {foot.x() - 0.20, foot.y() - 0.20, z},
                    {foot.x() + 0.20, foot.y() + 0.20, z + step});
  for (int k = 0; k < 2; ++k) {
    const double reach = 0.42 + 0.28 * k;
    z += step;
    builder->AddBlock(material, {foot.x() - reach, foot.y() - 0.09, z},
                      {foot.x() + reach, foot.y() + 0.09, z + step});
    builder->AddBlock(material, {foot.x() - 0.09, foot.y() - reach, z},
                      {foot.x() + 0.09, foot.y() + reach, z + step});
    z += step;
    for (const double d : {-1.0, 1.0}) {
      builder->AddBlock(material, {foot.x() + d * reach - 0.12, foot.y() - 0.12, z},
                        {foot.x() + d * reach + 0.12, foot.y() + 0.12, z + step});
      builder->AddBlock(material, {foot.x() - 0.12, foot.y() + d * reach - 0.12, z},
                        {foot.x() + 0.12, foot.y() + d * reach + 0.12, z + step});
    }
  }
}

void AddPlatform(const GateMaterials& m, SceneBuilder* builder) {
  builder->SetObject(kPlatform);
  builder->AddBlock(m.granite, {-8.0, -4.2, 0}, {8.0, 4.2, kFloor - 0.18}, 0.35);
  builder->AddBlock(m.granite, {-8.15, -4.35, kFloor - 0.18}, {8.15, 4.35, kFloor}, 0.35);
  for (int i = 0; i < 5; ++i) {  // stairs in the middle, front and back
    const double out = 4.35 + 0.34 * (5 - i), top = kFloor / 6 * (i + 1);
    builder->AddBlock(m.granite, {-2.2, -out, 0}, {2.2, out, top}, 0.35);
  }
  for (const double x : {-2.45, 2.45}) {
    for (const double side : {-1.0, 1.0}) {
      const double y0 = side * 4.3, y1 = side * 6.2;
      builder->AddBlock(m.granite, {x - 0.2, std::min(y0, y1), 0}, {x + 0.2, std::max(y0, y1), 0.5},
                        0.35);
    }
  }
}

void AddBays(const GateMaterials& m, SceneBuilder* builder) {
  for (int bay = 0; bay < 3; ++bay) {
    const double x0 = kColumnsX[bay] + 0.28, x1 = kColumnsX[bay + 1] - 0.28;
    if (bay == 1) {
      builder->AddBlock(m.door, {x0, -0.07, kFloor}, {x1, 0.07, 4.6}, 0.35);
    } else {
      builder->AddBlock(m.granite, {x0, -0.26, kFloor}, {x1, 0.26, 2.0}, 0.35);
      builder->AddBlock(m.plaster, {x0, -0.16, 2.0}, {x1, 0.16, 4.6}, 0.35);
    }
    builder->AddBlock(m.beam, {x0, -0.15, 4.6}, {x1, 0.15, 5.0}, 0.35);
    builder->AddBlock(m.wood, {x0, -0.06, 5.0}, {x1, 0.06, 6.0}, 0.35);
  }
  builder->AddBlock(m.plaque, {-1.1, -2.62, 6.02}, {1.1, -2.52, 6.8}, 0.35);
}

void AddHall(const GateMaterials& m, SceneBuilder* builder) {
  builder->SetObject(kHall);
  for (const double x : kColumnsX) {
    for (const double y : kColumnsY) {
      builder->AddTurned(m.granite, {x, y, kFloor},
                         {{0.52, 0}, {0.55, 0.10}, {0.50, 0.24}, {0.38, 0.30}}, 20);
      builder->AddTurned(m.column, {x, y, kFloor + 0.3},
                         {{0.33, 0}, {0.34, 1}, {0.34, 2}, {0.335, 3}, {0.325, 4}, {0.31, 5.5}},
                         20);
      AddBracket(m.beam, {x, y, 6.6}, 0.95, builder);
    }
    builder->AddBlock(m.beam, {x - 0.17, -2.9, 5.95}, {x + 0.17, 2.9, 6.5}, 0.4);
  }
  for (const double y : kColumnsY) {
    builder->AddBlock(m.beam, {-6.2, y - 0.18, 6.0}, {6.2, y + 0.18, 6.6}, 0.4);
    for (const double x : {-4.43, -3.27, -0.7, 0.7, 3.27, 4.43}) {
      AddBracket(m.beam, {x, y, 6.6}, 0.95, builder);
    }
  }
  for (const double y : {-2.95, 2.95}) {  // purlins that carry the rafters
    builder->AddBlock(m.column, {-6.6, y - 0.12, 7.5}, {6.6, y + 0.12, 7.75}, 0.5);
  }
  for (const double x : {-6.25, 6.25}) {
    builder->AddBlock(m.column, {x - 0.12, -3.2, 7.5}, {x + 0.12, 3.2, 7.75}, 0.5);
  }
  AddBays(m, builder);
}

void AddUpperHall(const GateMaterials& m, SceneBuilder* builder) {
  builder->SetObject(kUpperHall);
  builder->AddBlock(m.ridge, {-5.1, -1.8, 8.9}, {5.1, 1.8, 9.45}, 0.4);
  builder->AddBlock(m.wood, {-4.5, -1.4, 9.4}, {4.5, 1.4, 12.2}, 0.4);
  for (const double x : {-4.5, -2.7, -0.9, 0.9, 2.7, 4.5}) {
    for (const double y : {-1.42, 1.42}) {
      builder->AddTurned(m.column, {x, y, 9.4}, {{0.19, 0}, {0.19, 1}, {0.18, 2.0}}, 14);
      AddBracket(m.beam, {x, y, 11.5}, 0.7, builder);
    }
  }
  for (const double y : {-1.5, 1.5}) {
    builder->AddBlock(m.beam, {-4.8, y - 0.14, 11.1}, {4.8, y + 0.14, 11.5}, 0.4);
    builder->AddBlock(m.beam, {-4.7, y - 0.10, 9.5}, {4.7, y + 0.10, 9.8}, 0.4);
    // Lattice of the upper windows.
    for (double x = -4.2; x < 4.3; x += 0.3) {
      builder->AddBar(m.column, {x, y, 9.8}, {x, y, 11.1}, 0.06, 0.06, Eigen::Vector3d::UnitX());
    }
  }
  for (const double x : {-4.6, 4.6}) {
    builder->AddBlock(m.beam, {x - 0.14, -1.7, 11.1}, {x + 0.14, 1.7, 11.5}, 0.4);
    AddBracket(m.beam, {x, 0, 11.5}, 0.7, builder);
  }
}

void AddTopRidge(const GateMaterials& m, SceneBuilder* builder) {
  const double top = kUpper.eave_z + kUpper.rise, half = kUpper.top_x;
  builder->AddBlock(m.ridge, {-half - 0.1, -0.22, top - 0.1}, {half + 0.1, 0.22, top + 0.42}, 0.3);
  builder->AddBlock(m.ridge, {-half - 0.2, -0.27, top + 0.42}, {half + 0.2, 0.27, top + 0.52}, 0.3);
  for (const double x : {-half, half}) {
    builder->AddTurned(m.ridge, {x, 0, top + 0.5},
                       {{0.30, 0}, {0.34, 0.16}, {0.20, 0.30}, {0.22, 0.38}, {0, 0.5}}, 14);
  }
}

// A paved road through the gate.
GroundMasks GateGround() {
  GroundMasks masks;
  masks.paving = [](const Eigen::Vector2f& p) {
    const float road = SmoothStep(3.4F, 2.8F, std::abs(p.x() + 0.3F * Noise(p, 5)));
    const float dx = std::max(std::abs(p.x()) - 8.2F, 0.0F);
    const float dy = std::max(std::abs(p.y()) - 4.4F, 0.0F);
    return std::max(road, SmoothStep(2.6F, 1.8F, std::hypot(dx, dy)));
  };
  masks.gravel = [](const Eigen::Vector2f& p) {
    return SmoothStep(13.0F, 10.0F, std::hypot(p.x() * 0.8F, p.y()));
  };
  return masks;
}

}  // namespace

TexturedScene MakeGate(std::uint64_t seed, double texel_scale) {
  SceneBuilder builder(seed, texel_scale);
  const auto salt = static_cast<std::uint32_t>(seed) * 1000U + 400U;
  const GateMaterials materials = AddGateMaterials(salt, &builder);
  AddPlatform(materials, &builder);
  AddHall(materials, &builder);
  builder.SetObject(kLowerRoof);
  AddRoof(materials, kLower, &builder);
  AddUpperHall(materials, &builder);
  builder.SetObject(kUpperRoof);
  AddRoof(materials, kUpper, &builder);
  AddTopRidge(materials, &builder);
  AddOutdoorGround(salt + 40, GateGround(), &builder);
  return builder.Finish(kDefaultSceneOrigin);
}

}  // namespace colmap_ext
