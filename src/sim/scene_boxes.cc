// Cardboard buildings on the floor of a room of 8 x 8 m, open above. Floor and walls are ground.
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "sim/noise.h"
#include "sim/painters.h"
#include "sim/scene_builder.h"
#include "sim/scenes.h"

namespace colmap_ext {
namespace {

// The first flight, 1 m beside the buildings, stays a metre from the walls.
constexpr double kRoomHalf = 4.0, kRoomHeight = 2.4;  // m
constexpr double kEdge = 0.05;                        // m, of the triangles of a box
constexpr double kBulge = 0.004;                      // m, unevenness of cardboard

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

void Place(double x, double y, double turn_deg, SceneBuilder* builder, double z = 0) {
  builder->SetPlacement(Eigen::Translation3d(x, y, z) *
                        Eigen::Isometry3d(Eigen::AngleAxisd(DegToRad(turn_deg), kZ)));
}

// The four upright sides of a box around the local origin.
void AddSides(int material, double a, double b, double height, SceneBuilder* builder) {
  const auto side = [&](const PlaneFrame& frame, double width) {
    builder->AddRectangle(material, frame, width, height, kEdge, kBulge);
  };
  side({{-a / 2, -b / 2, 0}, kX, kZ}, a);
  side({{a / 2, -b / 2, 0}, kY, kZ}, b);
  side({{a / 2, b / 2, 0}, -kX, kZ}, a);
  side({{-a / 2, b / 2, 0}, -kY, kZ}, b);
}

void AddBox(int material, double a, double b, double height, SceneBuilder* builder,
            bool with_bottom = false) {
  AddSides(material, a, b, height, builder);
  builder->AddRectangle(material, {{-a / 2, -b / 2, height}, kX, kY}, a, b, kEdge, kBulge);
  if (with_bottom) {
    builder->AddRectangle(material, {{-a / 2, b / 2, 0}, kX, -kY}, a, b, kEdge);
  }
}

// House with a ridge along local y and a roof of thin board that overhangs.
void AddHouse(int material, double a, double b, double wall, double rise, SceneBuilder* builder) {
  const Polygon2d profile = {
      {-a / 2, 0}, {a / 2, 0}, {a / 2, wall}, {0, wall + rise}, {-a / 2, wall}};
  builder->AddPrism(material, {{0, -b / 2, 0}, kX, kZ}, profile, b, kEdge, true);
  const double over = 0.06, slope = rise / (a / 2), thick = 0.012;
  const Polygon2d board = {
      {-a / 2 - over, wall - over * slope}, {0, wall + rise},
      {a / 2 + over, wall - over * slope},  {a / 2 + over, wall - over * slope + thick},
      {0, wall + rise + thick * 1.4},       {-a / 2 - over, wall - over * slope + thick}};
  const PlaneFrame front{{0, -b / 2 - over, 0}, kX, kZ};
  builder->AddStrip(material, front, board, true, b + 2 * over, kEdge);
  builder->AddPolygon(material, front, board, {}, 0.2);
  Polygon2d back;
  for (auto p = board.rbegin(); p != board.rend(); ++p) back.emplace_back(-p->x(), p->y());
  builder->AddPolygon(material, {{0, b / 2 + over, 0}, -kX, kZ}, back, {}, 0.2);
}

void AddPyramid(int material, double half, double base, double rise, SceneBuilder* builder) {
  const Eigen::Isometry3d placement = builder->placement();
  const double run = std::hypot(half, rise);
  for (int side = 0; side < 4; ++side) {
    builder->SetPlacement(placement * Eigen::Isometry3d(Eigen::AngleAxisd(side * M_PI / 2, kZ)));
    builder->AddPolygon(material,
                        {{0, -half, base}, kX, Eigen::Vector3d(0, half / run, rise / run)},
                        {{-half, 0}, {half, 0}, {0, run}}, {}, kEdge);
  }
  builder->SetPlacement(placement);
  builder->AddRectangle(material, {{-half, half, base}, kX, -kY}, 2 * half, 2 * half, 0.1);
}

// Box without a lid, flaps folded outwards.
void AddOpenBox(int material, double a, double b, double height, SceneBuilder* builder) {
  AddSides(material, a, b, height, builder);
  const double wall = 0.012, ia = a - 2 * wall, ib = b - 2 * wall;
  builder->AddRectangle(material, {{-ia / 2, -ib / 2, 0.02}, kX, kY}, ia, ib, kEdge);
  const auto inner = [&](const PlaneFrame& frame, double width) {
    builder->AddRectangle(material, frame, width, height - 0.02, kEdge);
  };
  inner({{ia / 2, -ib / 2, 0.02}, -kX, kZ}, ia);
  inner({{ia / 2, ib / 2, 0.02}, -kY, kZ}, ib);
  inner({{-ia / 2, ib / 2, 0.02}, kX, kZ}, ia);
  inner({{-ia / 2, -ib / 2, 0.02}, kY, kZ}, ib);
  builder->AddPolygon(material, {{0, 0, height}, kX, kY},
                      RectanglePolygon(-a / 2, -b / 2, a / 2, b / 2),
                      {RectanglePolygon(-ia / 2, -ib / 2, ia / 2, ib / 2)}, 0.2);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d hinge(side * a / 2, 0, height - 0.006);
    builder->AddBar(material, hinge, hinge + Eigen::Vector3d(side * 0.24, 0, 0.10), b, 0.012);
    const Eigen::Vector3d other(0, side * b / 2, height - 0.006);
    builder->AddBar(material, other, other + Eigen::Vector3d(0, side * 0.16, -0.14), a, 0.012);
  }
}

void AddRoom(int floor, int wall, SceneBuilder* builder) {
  builder->SetObject(kGroundObject);
  builder->SetPlacement(Eigen::Isometry3d::Identity());
  const double half = kRoomHalf, size = 2 * kRoomHalf;
  builder->AddRectangle(floor, {{-half, -half, 0}, kX, kY}, size, size, 0.12);
  for (int side = 0; side < 4; ++side) {
    Place(0, 0, 90.0 * side, builder);
    builder->AddRectangle(wall, {{-half, half, 0}, kX, kZ}, size, kRoomHeight, 0.3);
  }
}

}  // namespace

TexturedScene MakeBoxes(std::uint64_t seed, double texel_scale) {
  SceneBuilder builder(seed, texel_scale);
  const auto salt = static_cast<std::uint32_t>(seed) * 1000U + 800U;
  const int board = builder.AddMaterial("cardboard", 0.003, Cardboard(salt + 1));
  const int floor = builder.AddMaterial("parquet", 0.003, Parquet(salt + 2));
  const int wall = builder.AddMaterial("wall", 0.004, PosteredWall(salt + 3));

  int object = 0;
  const auto next = [&](double x, double y, double turn_deg, double z = 0) {
    builder.SetObject(++object);
    Place(x, y, turn_deg, &builder, z);
  };
  next(-0.25, 0.95, 8);  // tower
  AddBox(board, 0.62, 0.62, 1.22, &builder);
  AddPyramid(board, 0.37, 1.22, 0.38, &builder);
  next(-1.35, -0.35, -14);
  AddHouse(board, 0.85, 1.25, 0.62, 0.42, &builder);
  next(1.2, 0.95, 20);
  AddBox(board, 1.0, 0.7, 0.9, &builder);
  next(0.15, -1.25, 5);  // stack
  AddBox(board, 0.75, 0.7, 0.58, &builder);
  next(0.18, -1.22, 38, 0.582);
  AddBox(board, 0.5, 0.46, 0.5, &builder);
  next(1.45, -0.55, -8);  // bridge on two piers
  AddBox(board, 0.36, 0.4, 0.62, &builder);
  next(1.33, -1.45, -8);
  AddBox(board, 0.36, 0.4, 0.62, &builder);
  next(1.39, -1.0, -8, 0.622);
  AddBox(board, 0.44, 1.45, 0.3, &builder, true);
  next(-1.3, 1.25, 33);
  AddOpenBox(board, 0.7, 0.6, 0.5, &builder);
  next(-0.85, -1.65, 12);
  AddBox(board, 0.55, 0.5, 0.78, &builder);
  next(0.3, -0.1, -25);
  AddHouse(board, 0.5, 0.6, 0.34, 0.22, &builder);
  AddRoom(floor, wall, &builder);
  return builder.Finish(kDefaultSceneOrigin);
}

}  // namespace colmap_ext
