// The private parts that scenes are made of: noise, patterns, polygon meshes, visibility.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/building_parts.h"
#include "sim/face_visibility.h"
#include "sim/noise.h"
#include "sim/polygon_mesher.h"
#include "sim/scene_builder.h"
#include "sim/texture.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

TEST(Noise, IsSmoothBoundedAndSeeded) {
  double mean = 0, other = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3f p(0.37F * static_cast<float>(i), -0.11F * static_cast<float>(i), 0.5F);
    const float value = Noise(p, 3);
    ASSERT_LE(std::abs(value), 1);
    ASSERT_NEAR(value, Noise(Eigen::Vector3f(p + Eigen::Vector3f::Constant(1e-3F)), 3), 0.02);
    mean += value / 4000;
    other += std::abs(value - Noise(p, 4)) / 4000;
  }
  EXPECT_NEAR(mean, 0, 0.05);
  EXPECT_GT(other, 0.2);
}

TEST(BrickAt, CellsAreConsistentAcrossTheirJoints) {
  const BrickPattern pattern{0.3F, 0.5F, 0.4F, 0.4F, 0, true};
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector2f uv(0.013F * static_cast<float>(i), 0.0071F * static_cast<float>(i) - 9);
    const BrickCell cell = BrickAt(pattern, uv, 1);
    ASSERT_GE(cell.Edge(), -1e-4);
    ASSERT_LT(cell.edge_v, 0.22);
    // The brick's lower left corner, a little inside, belongs to the same brick.
    const Eigen::Vector2f inside =
        uv - Eigen::Vector2f(cell.u, cell.v) + Eigen::Vector2f::Constant(2e-3F);
    ASSERT_EQ(BrickAt(pattern, inside, 1).hash, cell.hash);
  }
}

double AreaOf(const PlanarMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) {
    const auto& a = mesh.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector2d ab = mesh.vertices[static_cast<std::size_t>(face[1])] - a;
    const Eigen::Vector2d ac = mesh.vertices[static_cast<std::size_t>(face[2])] - a;
    const double twice = ab.x() * ac.y() - ab.y() * ac.x();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  return area;
}

TEST(MeshPolygon, CutsHolesKeepsAreaAndBoundsEdges) {
  const Polygon2d outer = RectanglePolygon(-3, 0, 3, 4);
  const PlanarMesh mesh =
      MeshPolygon(outer, {RectanglePolygon(-2, 1, -1, 3), {{1, 1}, {2, 1}, {1.5, 2}}}, 0.3);
  EXPECT_NEAR(AreaOf(mesh), 24 - 2 - 0.5, 1e-9);
  for (const auto& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(face[k]);
      const auto b = static_cast<std::size_t>(face[(k + 1) % 3]);
      EXPECT_LT((mesh.vertices[a] - mesh.vertices[b]).norm(), 0.45);
    }
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (std::abs(mesh.vertices[i].x()) > 2.9999) {
      EXPECT_TRUE(mesh.on_border[i]);
    }
  }
  EXPECT_TRUE(std::count(mesh.on_border.begin(), mesh.on_border.end(), false) > 0);
}

TEST(MeshPolygon, KeepsNotches) {
  const Polygon2d notched = {{0, 0}, {1, 0}, {1, 2}, {2, 2}, {2, 0}, {3, 0}, {3, 3}, {0, 3}};
  EXPECT_NEAR(AreaOf(MeshPolygon(notched, {}, 0.5)), 9 - 2, 1e-9);
}

TEST(FindVisibleFaces, DropsWhatIsInsideAndKeepsWhatSeesTheGround) {
  TexturedScene scene = test::GroundScene(test::FlatMaterial(100));
  test::AddCube({-2, -2, 0}, 4, 0, 1, &scene);   // its bottom lies on the ground
  test::AddCube({-1, -1, 1}, 1, 0, 2, &scene);   // all of it inside the first
  test::AddCube({5, -2, 1.5}, 3, 0, 3, &scene);  // hangs in the air: its bottom sees the ground
  const auto visible = FindVisibleFaces(scene.mesh, scene.object_of_face);
  int seen[4] = {0, 0, 0, 0};
  for (std::size_t i = 0; i < visible.size(); ++i) seen[scene.object_of_face[i]] += visible[i];
  EXPECT_EQ(seen[0], 2);
  EXPECT_EQ(seen[1], 10);
  EXPECT_EQ(seen[2], 0);
  EXPECT_EQ(seen[3], 12);
  KeepFaces(visible, &scene);
  EXPECT_NO_THROW(CheckScene(scene, "kept"));
  EXPECT_EQ(scene.mesh.faces.size(), 24u);
}

TEST(SceneBuilder, TextureLiesWhereThePainterPaintedIt) {
  SceneBuilder builder(1, 1);
  // Red grows with x, green with z: a face's texture must say where it is in the world.
  const int material = builder.AddMaterial("where", 0.02, [](const SurfacePoint& p) {
    return Eigen::Vector3f(p.world.x() / 10, p.world.z() / 10, 0);
  });
  builder.SetObject(1);
  builder.AddBlock(material, {1, 2, 3}, {4, 5, 9}, 0.7);
  builder.AddPolygon(material, {{0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()},
                     {{6, 1}, {9, 1}, {7, 6}}, {}, 0.8);
  const TexturedScene scene = builder.Finish(kDefaultSceneOrigin);
  const MipTexture texture(scene.materials[0].texture_bgr);
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    for (int k = 0; k < 3; ++k) {
      center += scene.mesh.vertices[static_cast<std::size_t>(scene.mesh.faces[i][k])] / 3;
      uv += scene.corner_uv[i][static_cast<std::size_t>(k)] / 3;
    }
    const Eigen::Vector3f bgr = texture.Sample(uv.x(), uv.y(), 0);
    ASSERT_NEAR(bgr[2] / 25.5, center.x(), 0.05);
    ASSERT_NEAR(bgr[1] / 25.5, center.z(), 0.05);
  }
}

TEST(SceneBuilder, SolidsPointOutwards) {
  SceneBuilder builder(1, 8);
  const int material =
      builder.AddMaterial("flat", 0.1, [](const SurfacePoint&) { return Eigen::Vector3f::Ones(); });
  builder.SetObject(1);
  const auto volume_of = [&](const auto& add) {
    SceneBuilder solid(1, 8);
    solid.AddMaterial("flat", 0.1, [](const SurfacePoint&) { return Eigen::Vector3f::Ones(); });
    solid.SetObject(1);
    add(solid);
    const TexturedScene scene = solid.Finish(kDefaultSceneOrigin);
    double volume = 0;
    for (const auto& face : scene.mesh.faces) {
      const auto v = [&](int k) { return scene.mesh.vertices[static_cast<std::size_t>(face[k])]; };
      volume += v(0).dot(v(1).cross(v(2))) / 6;
    }
    return volume;
  };
  EXPECT_NEAR(volume_of([&](auto& b) { b.AddBlock(material, {1, 1, 1}, {3, 4, 5}); }), 24, 1e-6);
  EXPECT_NEAR(volume_of([&](auto& b) {
                b.AddPrism(material,
                           {{0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()},
                           {{0, 0}, {2, 0}, {2, 1}, {0, 3}}, 1.5, 0.5, true);
              }),
              4 * 1.5, 1e-6);
  EXPECT_NEAR(volume_of([&](auto& b) {
                b.AddBar(material, {0, 0, 0}, {1, 2, 2}, 0.2, 0.3);
              }),
              3 * 0.06, 1e-6);
  // A turned cone with its base open to below: close it with the volume's own formula.
  EXPECT_NEAR(volume_of([&](auto& b) {
                b.AddTurned(material, {0, 0, 0}, {{0, 0}, {1, 0.5}, {0, 1}}, 200);
              }),
              M_PI / 3, 0.01);
}

TEST(AddWall, OpeningsAreRecessedAndDoorsReachTheGround) {
  SceneBuilder builder(1, 8);
  const int material =
      builder.AddMaterial("flat", 0.1, [](const SurfacePoint&) { return Eigen::Vector3f::Ones(); });
  Opening window;
  window.center_u = 2;
  window.sill_v = 1;
  window.pane_material = material;
  Opening door = window;
  door.center_u = 5;
  door.sill_v = 0;
  builder.SetObject(1);
  AddWall({material, material}, {{0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()},
          RectanglePolygon(0, 0, 7, 4), {window, door}, &builder);
  const TexturedScene scene = builder.Finish(kDefaultSceneOrigin);
  const Renderer renderer(scene, test::PlainLight());
  const PinholeCamera camera{1, 1, 1000, 1000, 0.5, 0.5};
  const auto depth_at = [&](double x, double z) {
    return renderer.RenderDepth(camera, CamFromWorld({x, -5, z}, {})).at<float>(0, 0);
  };
  EXPECT_NEAR(depth_at(2, 2), 5.3, 1e-4);      // the pane
  EXPECT_NEAR(depth_at(5, 0.02), 5.3, 1e-4);   // the door, down to its foot
  EXPECT_NEAR(depth_at(2.57, 2), 4.95, 1e-4);  // the surround stands out
  EXPECT_NEAR(depth_at(3.5, 2), 5, 0.013);     // the wall, uneven
}

}  // namespace
}  // namespace colmap_ext
