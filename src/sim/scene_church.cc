// The church: local x east, nave from west to east, tower in the west, porch in the south.
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "sim/building_parts.h"
#include "sim/noise.h"
#include "sim/painters.h"
#include "sim/scenes.h"

namespace colmap_ext {
namespace {

enum Part { kNave = 1, kTower = 2, kChancel = 3, kPorch = 4, kButtresses = 5, kSpire = 6 };

struct ChurchMaterials {
  BuildingMaterials building;
  int glass = 0, door = 0, louvre = 0, iron = 0;
};

constexpr double kTowerWest = -10.6, kTowerSize = 5.2, kTowerHeight = 12.6;
constexpr double kNaveWest = kTowerWest + kTowerSize, kNaveLength = 11.4, kNaveWidth = 8.2;
constexpr double kChancelLength = 4.4, kChancelWidth = 5.6;

ChurchMaterials AddChurchMaterials(std::uint32_t seed, SceneBuilder* builder) {
  ChurchMaterials m;
  m.building.walls.wall = builder->AddMaterial("rubble", 0.014, RubbleStone(seed + 1));
  m.building.walls.trim = builder->AddMaterial("dressed_stone", 0.014,
                                               DressedStone(seed + 2, Rgb(0.80F, 0.76F, 0.66F)));
  m.building.tiles = builder->AddMaterial(
      "roof_tiles", 0.014,
      RoofTiles(seed + 3, 0.32F, Rgb(0.38F, 0.21F, 0.16F), Rgb(0.60F, 0.37F, 0.27F)));
  m.building.wood = builder->AddMaterial("planks", 0.014,
                                         Planks(seed + 4, 0.16F, Rgb(0.40F, 0.29F, 0.19F), true));
  m.glass = builder->AddMaterial("leaded_glass", 0.014, LeadedGlass(seed + 5));
  m.door =
      builder->AddMaterial("door", 0.014, Planks(seed + 6, 0.18F, Rgb(0.36F, 0.23F, 0.14F), false));
  m.louvre = builder->AddMaterial("louvres", 0.014,
                                  Planks(seed + 7, 0.20F, Rgb(0.45F, 0.40F, 0.34F), true));
  m.iron = builder->AddMaterial("iron", 0.02, Iron(seed + 8));
  return m;
}

Opening Window(const ChurchMaterials& m, double u, double sill, double width, double height) {
  Opening o;
  o.center_u = u;
  o.sill_v = sill;
  o.width = width;
  o.height = height;
  o.style = OpeningStyle::kPointed;
  o.pane_material = m.glass;
  o.bar_material = m.building.walls.trim;
  return o;
}

Opening Door(const ChurchMaterials& m, double u, double width, double height) {
  Opening o;
  o.center_u = u;
  o.sill_v = 0;
  o.width = width;
  o.height = height;
  o.style = OpeningStyle::kPointed;
  o.depth = 0.45;
  o.surround = 0.28;
  o.pane_material = m.door;
  return o;
}

Eigen::Isometry3d Placed(double x, double y, double turn_rad = 0) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::Isometry3d::Identity();
}

// Band of dressed stone around a rectangular body that reaches from x0 to x1.
void AddBand(int material, double x0, double x1, double half, double z0, double z1, double proud,
             SceneBuilder* builder) {
  const Polygon2d inner = RectanglePolygon(x0, -half, x1, half);
  const Polygon2d outer = RectanglePolygon(x0 - proud, -half - proud, x1 + proud, half + proud);
  const PlaneFrame top{{0, 0, z1}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  builder->AddStrip(material, top, outer, true, z1 - z0, 0.5);
  builder->AddPolygon(material, top, outer, {inner}, 0.5);
  if (z0 <= 0) return;
  // From below, y runs the other way; the bands are symmetric in y.
  const PlaneFrame bottom{{0, 0, z0}, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitY()};
  builder->AddPolygon(material, bottom, outer, {inner}, 0.5);
}

void AddNave(const ChurchMaterials& m, SceneBuilder* builder) {
  GabledBuilding nave;
  nave.length = kNaveLength;
  nave.width = kNaveWidth;
  nave.wall_height = 6.0;
  nave.pitch_rad = DegToRad(44);
  // Between the buttresses; the porch stands before the first bay in the south.
  for (const double u : {4.45, 7.15, 9.85}) nave.south.push_back(Window(m, u, 1.9, 1.15, 3.1));
  for (const double u : {1.55, 4.25, 6.95, 9.65}) {
    nave.north.push_back(Window(m, u, 1.9, 1.15, 3.1));
  }
  builder->SetObject(kNave);
  builder->SetPlacement(Placed(kNaveWest, 0));
  AddGabledBuilding(nave, m.building, builder);
  AddBand(m.building.walls.trim, 0.2, kNaveLength, kNaveWidth / 2, 0, 0.55, 0.10, builder);

  builder->SetObject(kButtresses);
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  for (const double u : {3.1, 5.8, 8.5, 11.05}) {
    AddButtress(m.building.walls, {{u, -kNaveWidth / 2, 0}, x, z}, 0.65, 4.9, 1.0, builder);
  }
  for (const double u : {0.4, 3.1, 5.8, 8.5, 11.05}) {
    AddButtress(m.building.walls, {{u, kNaveWidth / 2, 0}, -x, z}, 0.65, 4.9, 1.0, builder);
  }
}

void AddChancel(const ChurchMaterials& m, SceneBuilder* builder) {
  GabledBuilding chancel;
  chancel.length = kChancelLength;
  chancel.width = kChancelWidth;
  chancel.wall_height = 4.4;
  chancel.pitch_rad = DegToRad(44);
  chancel.verge_low = 0;
  chancel.low_gable_wall = false;
  chancel.south = {Window(m, 1.35, 1.6, 0.85, 2.2), Window(m, 3.1, 1.6, 0.85, 2.2)};
  chancel.north = chancel.south;
  chancel.gable_high = {Window(m, 0, 1.7, 1.7, 3.6)};
  builder->SetObject(kChancel);
  builder->SetPlacement(Placed(kNaveWest + kNaveLength, 0));
  AddGabledBuilding(chancel, m.building, builder);
  AddBand(m.building.walls.trim, 0.2, kChancelLength, kChancelWidth / 2, 0, 0.5, 0.10, builder);
}

void AddPorch(const ChurchMaterials& m, SceneBuilder* builder) {
  GabledBuilding porch;
  porch.length = 2.3;
  porch.width = 2.7;
  porch.wall_height = 2.5;
  porch.pitch_rad = DegToRad(46);
  porch.eaves = 0.35;
  porch.verge_low = 0;
  porch.low_gable_wall = false;
  porch.gable_high = {Door(m, 0, 1.35, 2.7)};
  porch.south = {Window(m, 1.15, 1.1, 0.5, 1.0)};
  porch.north = porch.south;
  builder->SetObject(kPorch);
  builder->SetPlacement(Placed(kNaveWest + 1.55, -kNaveWidth / 2, -M_PI / 2));
  AddGabledBuilding(porch, m.building, builder);
  // Steps before the door.
  for (int i = 0; i < 2; ++i) {
    builder->AddBlock(m.building.walls.trim, {2.2, -1.1 - 0.3 * i, 0},
                      {2.75 + 0.35 * i, 1.1 + 0.3 * i, 0.26 - 0.13 * i}, 0.4);
  }
}

Opening Belfry(const ChurchMaterials& m, double u) {
  Opening o = Window(m, u, 9.95, 0.95, 2.1);
  o.style = OpeningStyle::kArched;
  o.depth = 0.4;
  o.pane_material = m.iron;
  o.bar_material = m.louvre;
  o.louvres = true;
  return o;
}

void AddTowerWalls(const ChurchMaterials& m, SceneBuilder* builder) {
  const double size = kTowerSize;
  const Polygon2d wall = RectanglePolygon(0, 0, size, kTowerHeight);
  const std::vector<Opening> bells = {Belfry(m, size / 2 - 0.95), Belfry(m, size / 2 + 0.95)};
  for (int side = 0; side < 4; ++side) {  // south, east, north, west
    std::vector<Opening> openings = bells;
    if (side == 3) {
      openings.push_back(Door(m, size / 2, 1.7, 3.1));
      openings.push_back(Window(m, size / 2, 5.0, 1.3, 2.7));
    } else if (side != 1) {
      openings.push_back(Window(m, size / 2, 5.4, 0.6, 1.7));
      openings.push_back(Window(m, size / 2, 1.9, 0.6, 1.7));
    }
    builder->SetPlacement(Placed(kTowerWest + size / 2, 0, side * M_PI / 2));
    const PlaneFrame frame{
        {-size / 2, -size / 2, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
    AddWall(m.building.walls, frame, wall, openings, builder);
  }
}

void AddTowerTrim(const ChurchMaterials& m, SceneBuilder* builder) {
  const double size = kTowerSize, half = size / 2;
  const int trim = m.building.walls.trim;
  builder->SetPlacement(Placed(kTowerWest + half, 0));
  for (const double z : {4.35, 9.3}) AddBand(trim, -half, half, half, z, z + 0.22, 0.09, builder);
  AddBand(trim, -half, half, half, kTowerHeight - 0.35, kTowerHeight, 0.16, builder);
  // Clasping corner piers.
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      for (int step = 0; step < 2; ++step) {
        const double reach = step == 0 ? 0.34 : 0.2, top = step == 0 ? 4.0 : 8.5;
        const Eigen::Vector3d corner(sx * half, sy * half, 0);
        const Eigen::Vector3d a = corner + Eigen::Vector3d(sx, sy, 0) * reach;
        const Eigen::Vector3d b = corner - Eigen::Vector3d(sx, sy, 0) * 0.55;
        builder->AddBlock(m.building.walls.wall, a.cwiseMin(b),
                          a.cwiseMax(b) + Eigen::Vector3d(0, 0, top), 0.35);
        const Eigen::Vector3d lip(0.06, 0.06, 0);
        builder->AddBlock(trim, a.cwiseMin(b) + Eigen::Vector3d(0, 0, top) - lip,
                          a.cwiseMax(b) + Eigen::Vector3d(0, 0, top + 0.16) + lip, 0.35);
      }
    }
  }
}

void AddSpire(const ChurchMaterials& m, SceneBuilder* builder) {
  const double half = kTowerSize / 2 + 0.6, rise = 6.4, base = kTowerHeight + 0.12;
  const double run = std::hypot(half, rise);
  for (int side = 0; side < 4; ++side) {
    builder->SetPlacement(Placed(kTowerWest + kTowerSize / 2, 0, side * M_PI / 2));
    const PlaneFrame slope{
        {0, -half, base}, Eigen::Vector3d::UnitX(), Eigen::Vector3d(0, half / run, rise / run)};
    AddTileSlope(m.building.tiles, {slope, half, 0.0, run, 0.32, 0.045}, builder);
    builder->AddBar(m.building.tiles, {half - 0.02, -half + 0.02, base + 0.05},
                    {0, 0, base + rise + 0.05}, 0.24, 0.16);
    // Eave board and the beams' ends below it.
    builder->AddRectangle(
        m.building.wood,
        {{-half, -half, base - 0.16}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()}, 2 * half,
        0.16, 0.5);
    for (int i = 0; i < 9; ++i) {
      const double x = -half + 0.7 + (2 * half - 1.4) * i / 8;
      builder->AddBar(m.building.wood, {x, -half + 0.08, base - 0.23},
                      {x, -kTowerSize / 2 + 0.05, base - 0.23}, 0.12, 0.14);
    }
  }
  const double wall = kTowerSize / 2;
  builder->AddPolygon(m.building.wood,
                      {{0, 0, base - 0.16}, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitY()},
                      RectanglePolygon(-half, -half, half, half),
                      {RectanglePolygon(-wall, -wall, wall, wall)}, 0.5);
  const double tip = base + rise;
  builder->AddTurned(m.iron, {0, 0, tip - 0.05},
                     {{0.10, 0}, {0.10, 0.12}, {0.17, 0.22}, {0.17, 0.32}, {0.06, 0.42}, {0, 0.44}},
                     12);
  builder->AddBlock(m.iron, {-0.05, -0.05, tip + 0.3}, {0.05, 0.05, tip + 1.1}, 0.4);
  builder->AddBlock(m.iron, {-0.05, -0.32, tip + 0.68}, {0.05, 0.32, tip + 0.78}, 0.4);
}

float DistanceToSegment(const Eigen::Vector2f& p, const Eigen::Vector2f& a,
                        const Eigen::Vector2f& b) {
  const Eigen::Vector2f ab = b - a;
  const float t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0F, 1.0F);
  return (p - a - t * ab).norm();
}

// Paths from both doors to the south west, paving along the walls.
GroundMasks ChurchGround() {
  GroundMasks masks;
  masks.gravel = [](const Eigen::Vector2f& p) {
    static const Eigen::Vector2f kPath[] = {{-3.8F, -6.0F},   {-4.5F, -10.0F},  {-9.0F, -15.0F},
                                            {-18.0F, -19.0F}, {-30.0F, -26.0F}, {-45.0F, -40.0F}};
    float distance = DistanceToSegment(p, {-11.0F, 0.0F}, {-14.5F, -4.0F});
    distance = std::min(distance, DistanceToSegment(p, {-14.5F, -4.0F}, {-13.0F, -16.5F}));
    for (int i = 0; i + 1 < 6; ++i) {
      distance = std::min(distance, DistanceToSegment(p, kPath[i], kPath[i + 1]));
    }
    return SmoothStep(2.0F, 0.6F, distance);
  };
  masks.paving = [](const Eigen::Vector2f& p) {
    const auto outside = [&p](float x0, float x1, float y0, float y1) {
      const float dx = std::max(std::max(x0 - p.x(), p.x() - x1), 0.0F);
      const float dy = std::max(std::max(y0 - p.y(), p.y() - y1), 0.0F);
      return std::hypot(dx, dy);
    };
    const float distance =
        std::min(outside(-10.6F, 6.0F, -4.1F, 4.1F),
                 std::min(outside(6, 10.4F, -2.8F, 2.8F), outside(-5.4F, -2.3F, -7.0F, -4)));
    return SmoothStep(2.2F, 1.4F, distance);
  };
  return masks;
}

}  // namespace

TexturedScene MakeChurch(std::uint64_t seed, double texel_scale) {
  SceneBuilder builder(seed, texel_scale);
  const auto salt = static_cast<std::uint32_t>(seed) * 1000U;
  const ChurchMaterials materials = AddChurchMaterials(salt, &builder);
  AddNave(materials, &builder);
  AddChancel(materials, &builder);
  AddPorch(materials, &builder);
  builder.SetObject(kTower);
  AddTowerWalls(materials, &builder);
  AddTowerTrim(materials, &builder);
  builder.SetObject(kSpire);
  AddSpire(materials, &builder);
  builder.SetPlacement(Eigen::Isometry3d::Identity());
  AddOutdoorGround(salt + 40, ChurchGround(), &builder);
  return builder.Finish(kDefaultSceneOrigin);
}

}  // namespace colmap_ext
