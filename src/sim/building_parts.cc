#include "sim/building_parts.h"

#include <algorithm>
#include <cmath>

#include "sim/noise.h"
#include "sim/painters.h"

namespace colmap_ext {
namespace {

constexpr double kWallEdge = 0.32;     // m, of the triangles of a wall
constexpr double kWallRelief = 0.012;  // m, unevenness of rubble walls
constexpr double kProud = 0.05;        // m, that surrounds stand out

// Arch over the span [left, right] springing at `spring`, from right to left, ends included.
void AppendArch(const Opening& opening, double left, double right, double spring,
                Polygon2d* outline) {
  constexpr int kSteps = 7;
  const double span = right - left, middle = (left + right) / 2;
  if (opening.style == OpeningStyle::kArched) {
    for (int i = 0; i <= 2 * kSteps; ++i) {
      const double turn = M_PI * i / (2 * kSteps);
      outline->emplace_back(middle + span / 2 * std::cos(turn), spring + span / 2 * std::sin(turn));
    }
    return;
  }
  // Pointed: two arcs of radius `span` that meet above the middle at 60 degrees.
  for (int i = 0; i <= kSteps; ++i) {
    const double turn = M_PI / 3 * i / kSteps;
    outline->emplace_back(left + span * std::cos(turn), spring + span * std::sin(turn));
  }
  for (int i = kSteps - 1; i >= 0; --i) {
    const double turn = M_PI / 3 * i / kSteps;
    outline->emplace_back(right - span * std::cos(turn), spring + span * std::sin(turn));
  }
}

bool IsDoor(const Opening& opening) { return opening.sill_v <= 0; }

// `outline`, whose first edge is its foot, with the door cut out of it; a hole that touched the
// foot would be no hole.
Polygon2d CutDoor(const Polygon2d& outline, const Polygon2d& door) {
  Polygon2d cut = {outline[0], door[0]};
  cut.insert(cut.end(), door.rbegin(), door.rend() - 2);
  cut.push_back(door[1]);
  cut.insert(cut.end(), outline.begin() + 1, outline.end());
  return cut;
}

void AddSurround(const WallMaterials& materials, const PlaneFrame& frame, const Opening& opening,
                 SceneBuilder* builder) {
  const Polygon2d inner = OpeningOutline(opening, 0);
  const Polygon2d outer = OpeningOutline(opening, opening.surround);
  const PlaneFrame front = frame.Moved(0, 0, kProud);
  if (IsDoor(opening)) {
    builder->AddPolygon(materials.trim, front, CutDoor(outer, inner), {}, 0.25);
  } else {
    builder->AddPolygon(materials.trim, front, outer, {inner}, 0.25);
  }
  builder->AddStrip(materials.trim, front, outer, true, kProud, 0.4);
}

void AddLouvres(const PlaneFrame& frame, const Opening& o, SceneBuilder* builder) {
  for (double v = o.sill_v + 0.08; v < o.sill_v + o.height - 0.35 * o.width; v += 0.24) {
    builder->AddBar(o.bar_material, frame.At(o.center_u - o.width / 2, v, -o.depth * 0.55),
                    frame.At(o.center_u + o.width / 2, v, -o.depth * 0.55), 0.22, 0.04,
                    frame.v + 0.8 * frame.Normal());
  }
}

void AddMullions(const PlaneFrame& frame, const Opening& o, SceneBuilder* builder) {
  const double out = -o.depth * 0.6;
  builder->AddBar(o.bar_material, frame.At(o.center_u, o.sill_v, out),
                  frame.At(o.center_u, o.sill_v + o.height, out), 0.10, 0.12, frame.Normal());
  builder->AddBar(o.bar_material,
                  frame.At(o.center_u - o.width / 2, o.sill_v + o.height * 0.5, out),
                  frame.At(o.center_u + o.width / 2, o.sill_v + o.height * 0.5, out), 0.12, 0.08);
}

void AddSill(const WallMaterials& materials, const PlaneFrame& frame, const Opening& o,
             SceneBuilder* builder) {
  const double half = o.width / 2 + o.surround;
  const PlaneFrame front = frame.Moved(o.center_u, o.sill_v - o.surround, 0.14);
  builder->AddPrism(materials.trim, front, RectanglePolygon(-half, -0.10, half, 0.02), 0.14, 0.4);
}

void AddOpening(const WallMaterials& materials, const PlaneFrame& frame, const Opening& opening,
                SceneBuilder* builder) {
  const Polygon2d inner = OpeningOutline(opening, 0);
  const double proud = opening.surround > 0 ? kProud : 0;
  if (opening.surround > 0) AddSurround(materials, frame, opening, builder);
  // Reveal: seen from inside the hole, hence against the outline's direction. The ground is a
  // door's threshold.
  Polygon2d reversed(inner.rbegin(), inner.rend());
  if (IsDoor(opening)) std::rotate(reversed.begin(), reversed.end() - 1, reversed.end());
  builder->AddStrip(materials.trim, frame.Moved(0, 0, proud), reversed, !IsDoor(opening),
                    opening.depth + proud, 0.3);
  builder->AddPolygon(opening.pane_material, frame.Moved(0, 0, -opening.depth), inner, {}, 0.5);
  if (opening.bar_material >= 0 && opening.louvres) AddLouvres(frame, opening, builder);
  if (opening.bar_material >= 0 && !opening.louvres) AddMullions(frame, opening, builder);
  if (opening.sill_v > 0.4 && opening.surround > 0) AddSill(materials, frame, opening, builder);
}

// Tail ends of the rafters under an eave.
void AddRafters(const GabledBuilding& b, int wood, double side, SceneBuilder* builder) {
  const double slope = std::tan(b.pitch_rad);
  const int count = static_cast<int>(b.length / 0.62);
  for (int i = 0; i <= count; ++i) {
    const double x = 0.1 + (b.length - 0.2) * i / count;
    const double y0 = b.width / 2 - 0.05, y1 = b.width / 2 + b.eaves - 0.06;
    const auto under = [&](double y) { return b.wall_height - (y - b.width / 2) * slope - 0.07; };
    builder->AddBar(wood, {x, side * y0, under(y0)}, {x, side * y1, under(y1)}, 0.10, 0.14);
  }
}

// Underside, eave board and verges of one slope; side -1 south, +1 north.
void AddRoofSide(const GabledBuilding& b, const BuildingMaterials& materials, double side,
                 SceneBuilder* builder) {
  const double half = b.width / 2 + b.eaves, slope = std::tan(b.pitch_rad);
  const double eave_z = b.wall_height - b.eaves * slope;
  const double run = half / std::cos(b.pitch_rad);
  const double x0 = -b.verge_low, x1 = b.length + b.verge_high;
  const Eigen::Vector3d up(0, -side * std::cos(b.pitch_rad), std::sin(b.pitch_rad));
  const Eigen::Vector3d along(-side, 0, 0);
  const Eigen::Vector3d eave_middle((x0 + x1) / 2, side * half, eave_z);
  const PlaneFrame top{eave_middle + b.thickness * along.cross(up), along, up};
  AddTileSlope(
      materials.tiles,
      {top, (x1 - x0) / 2, (x1 - x0) / 2, run + b.thickness * std::tan(b.pitch_rad), 0.32, 0.045},
      builder);
  const PlaneFrame under{eave_middle + along * ((x0 - x1) / 2) + run * up, along, -up};
  builder->AddRectangle(materials.wood, under, x1 - x0, run, 0.6);
  const Polygon2d outline =
      RectanglePolygon(-(x1 - x0) / 2, 0, (x1 - x0) / 2, run + b.thickness * slope);
  builder->AddStrip(materials.wood, top, outline, true, b.thickness, 0.6);
  AddRafters(b, materials.wood, side, builder);
}

void AddRidge(const GabledBuilding& b, int tiles, SceneBuilder* builder) {
  const double z = b.RidgeHeight() + b.thickness / std::cos(b.pitch_rad);
  const double x0 = -b.verge_low - 0.02, x1 = b.length + b.verge_high + 0.02;
  const int pieces = static_cast<int>((x1 - x0) / 0.45);
  const Polygon2d section = {
      {-0.17, -0.10}, {0.17, -0.10}, {0.13, 0.06}, {0.0, 0.12}, {-0.13, 0.06}};
  for (int i = 0; i < pieces; ++i) {
    const double from = x0 + (x1 - x0) * i / pieces;
    const double length = (x1 - x0) / pieces + 0.03;
    const PlaneFrame end{{from + length, 0, z + 0.012 * (i % 2)},
                         Eigen::Vector3d::UnitY(),
                         Eigen::Vector3d::UnitZ()};
    builder->AddPrism(tiles, end, section, length, 0.5, i == 0);
  }
}

}  // namespace

Polygon2d OpeningOutline(const Opening& o, double grow) {
  const double left = o.center_u - o.width / 2 - grow, right = o.center_u + o.width / 2 + grow;
  const double bottom = o.sill_v - (o.sill_v > 0.4 ? grow : 0);
  Polygon2d outline = {{left, bottom}, {right, bottom}};
  if (o.style == OpeningStyle::kRectangular) {
    outline.emplace_back(right, o.sill_v + o.height + grow);
    outline.emplace_back(left, o.sill_v + o.height + grow);
    return outline;
  }
  const double rise = o.width * (o.style == OpeningStyle::kArched ? 0.5 : std::sqrt(0.75));
  AppendArch(o, left, right, o.sill_v + o.height - rise, &outline);
  return outline;
}

void AddWall(const WallMaterials& materials, const PlaneFrame& frame, const Polygon2d& outline,
             const std::vector<Opening>& openings, SceneBuilder* builder) {
  std::vector<Polygon2d> holes;
  Polygon2d wall = outline;
  for (const Opening& opening : openings) {
    const Polygon2d hole = OpeningOutline(opening, opening.surround);
    if (IsDoor(opening)) {
      wall = CutDoor(outline, hole);
    } else {
      holes.push_back(hole);
    }
  }
  builder->AddPolygon(materials.wall, frame, wall, holes, kWallEdge, kWallRelief);
  for (const Opening& opening : openings) AddOpening(materials, frame, opening, builder);
}

void AddTileSlope(int material, const TileSlope& s, SceneBuilder* builder) {
  const double half = std::max(s.eave_half, s.ridge_half);
  const PlaneFrame corner = s.frame.Moved(-half, 0);
  const int chart = builder->AddChart(material, {2 * half, s.length}, {0, 0},
                                      [corner](const Eigen::Vector2d& p) { return corner.At(p); });
  const auto half_at = [&](double v) {
    return s.eave_half + (s.ridge_half - s.eave_half) * v / s.length;
  };
  const int courses = std::max(1, static_cast<int>(std::ceil(s.length / s.course - 1e-6)));
  const int columns = std::max(1, static_cast<int>(std::ceil(2 * half / 0.3)));
  // Row of vertices at height v on the slope, lifted by `out`; returns the first index.
  const auto row = [&](double v, double out, double jitter, int salt) {
    int first = -1;
    for (int i = 0; i <= columns; ++i) {
      const double u = half_at(v) * (2.0 * i / columns - 1);
      const double wave = i == 0 || i == columns ? 0.5 : HashUnit(i, salt, 4, 99U);
      const int index =
          builder->AddVertex(chart, s.frame.At(u, v, out + jitter * (wave - 0.5)), {u + half, v});
      if (first < 0) first = index;
    }
    return first;
  };
  const auto join = [&](int lower, int upper) {
    for (int i = 0; i < columns; ++i) {
      builder->AddTriangle(lower + i, lower + i + 1, upper + i + 1);
      builder->AddTriangle(lower + i, upper + i + 1, upper + i);
    }
  };
  for (int k = 0; k < courses; ++k) {
    const double v0 = k * s.course, v1 = std::min(s.length, (k + 1) * s.course);
    const int foot = row(v0, -0.005, 0, 2 * k);
    const int nose = row(v0, s.lift, 0.016, 2 * k + 1);
    join(foot, nose);
    const int lower = row(v0, s.lift, 0.016, 2 * k + 1);
    const int upper = row(v1, 0, 0, 2 * k + 2);
    join(lower, upper);
  }
}

double GabledBuilding::RidgeHeight() const { return wall_height + width / 2 * std::tan(pitch_rad); }

void AddGabledBuilding(const GabledBuilding& b, const BuildingMaterials& materials,
                       SceneBuilder* builder) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const double half = b.width / 2;
  const Polygon2d side = RectanglePolygon(0, 0, b.length, b.wall_height);
  AddWall(materials.walls, {-half * y, x, z}, side, b.south, builder);
  AddWall(materials.walls, {b.length * x + half * y, -x, z}, side, b.north, builder);
  const Polygon2d gable = {
      {-half, 0}, {half, 0}, {half, b.wall_height}, {0, b.RidgeHeight()}, {-half, b.wall_height}};
  AddWall(materials.walls, {b.length * x, y, z}, gable, b.gable_high, builder);
  if (b.low_gable_wall) AddWall(materials.walls, {{0, 0, 0}, -y, z}, gable, {}, builder);
  AddRoofSide(b, materials, -1, builder);
  AddRoofSide(b, materials, +1, builder);
  AddRidge(b, materials.tiles, builder);
}

void AddButtress(const WallMaterials& materials, const PlaneFrame& frame, double width,
                 double height, double depth, SceneBuilder* builder) {
  // Profile seen from the side: x out of the wall, y up.
  const double step = 0.42 * height, top = 0.82 * height, upper = 0.6 * depth;
  const Polygon2d profile = {{0, 0},       {depth, 0},   {depth, step}, {upper, step + 0.45},
                             {upper, top}, {0.0, height}};
  const PlaneFrame side{frame.At(width / 2, 0), frame.Normal(), frame.v};  // looks along -u
  Polygon2d body;
  for (const auto& p : profile) body.emplace_back(p);
  // The frame's outside is -u; the other cap is added mirrored.
  builder->AddPrism(materials.wall, PlaneFrame{frame.At(-width / 2, 0), frame.Normal(), frame.v},
                    body, width, 0.35, true);
  // Weathering slabs on the two slopes.
  const auto slab = [&](const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    const Eigen::Vector3d from = side.At(low) + 0.03 * frame.Normal();
    const Eigen::Vector3d up = (side.At(high) - side.At(low)).normalized();
    const PlaneFrame top_face{from - frame.u * (width / 2), frame.u, up};
    builder->AddPrism(
        materials.trim, top_face.Moved(0, -0.08, 0.05),
        RectanglePolygon(-width / 2 - 0.05, 0, width / 2 + 0.05, (high - low).norm() + 0.10), 0.10,
        0.4);
  };
  slab(profile[2], profile[3]);
  slab(profile[4], profile[5]);
}

void AddOutdoorGround(std::uint32_t seed, const GroundMasks& masks, SceneBuilder* builder) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  const PlaneFrame flat{Eigen::Vector3d::Zero(), x, y};
  const Painter painter = Ground(seed, masks);
  const auto square = [](double half) { return RectanglePolygon(-half, -half, half, half); };
  builder->SetObject(kGroundObject);
  builder->AddRectangle(builder->AddMaterial("ground_near", 0.022, painter), flat.Moved(-22, -22),
                        44, 44, 0.55);
  builder->AddPolygon(builder->AddMaterial("ground", 0.05, painter), flat, square(40), {square(22)},
                      3);
  builder->AddPolygon(builder->AddMaterial("ground_far", 0.3, Meadow(seed)), flat, square(200),
                      {square(40)}, 30);
}

}  // namespace colmap_ext
