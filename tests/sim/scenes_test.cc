#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/sim/scene_views.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

constexpr double kQuick = 8;  // texel scale where textures do not matter

int CountModelFaces(const TexturedScene& scene) {
  int count = 0;
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) count += scene.IsGround(i) ? 0 : 1;
  return count;
}

// What must hold for every procedural scene.
void ExpectSound(const TexturedScene& scene) {
  EXPECT_NO_THROW(CheckScene(scene, "scene"));
  const GroundTruth truth = scene.Truth();
  const int model_faces = CountModelFaces(scene);
  EXPECT_EQ(static_cast<int>(truth.model.faces.size()), model_faces);
  EXPECT_GT(model_faces, 20000);
  EXPECT_LT(model_faces, 200000);
  EXPECT_LT(model_faces, static_cast<int>(scene.mesh.faces.size()));  // there is ground
  EXPECT_NEAR(BoundsOf(truth.model).min().z(), 0, 1e-9);
  for (std::size_t i = 0; i < truth.model.faces.size(); ++i) {  // nothing stands on its footprint
    const auto& face = truth.model.faces[i];
    double highest = 0;
    for (int k = 0; k < 3; ++k) {
      highest = std::max(highest, truth.model.vertices[static_cast<std::size_t>(face[k])].z());
    }
    ASSERT_GT(highest, 1e-6) << "face " << i << " lies on the ground";
  }
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) {
    ASSERT_GT(FaceArea(scene.mesh, i), 0);
    for (const auto& uv : scene.corner_uv[i]) {
      ASSERT_TRUE((uv.array() >= 0).all() && (uv.array() <= 1).all());
    }
  }
  EXPECT_TRUE(IsValid(scene.origin));
}

// Distance from `from` along the unit vector `along` to the model.
double DistanceTo(const RayScene& rays, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  const auto hit = rays.Intersect(from, along, 0, 1e3);
  return hit ? hit->distance_m : -1;
}

TEST(Church, HasTheSizeAndReliefOfAChurch) {
  const TexturedScene scene = MakeScene("church", 1, kQuick);
  ExpectSound(scene);
  const TriangleMesh model = scene.Truth().model;
  const BoundingBox box = BoundsOf(model);
  EXPECT_NEAR(box.sizes().x(), 21.5, 1.5);
  EXPECT_NEAR(box.sizes().z(), 20, 1.5);
  const RayScene rays(model);
  const Eigen::Vector3d north(0, 1, 0);
  // South wall of the nave between a buttress and a window, and the pane in the window.
  const double wall = DistanceTo(rays, {0.87, -20, 3.0}, north);
  const double pane = DistanceTo(rays, {2.05, -20, 3.0}, north);
  EXPECT_NEAR(wall, 20 - 4.1, 0.05);
  EXPECT_NEAR(pane - wall, 0.3, 0.05);
  // Eaves: from the wall's foot straight up, 0.4 m and 0.7 m outside the wall.
  EXPECT_GT(DistanceTo(rays, {-1.6, -4.5, 5}, Eigen::Vector3d::UnitZ()), 0);
  EXPECT_LT(DistanceTo(rays, {-1.6, -4.95, 5}, Eigen::Vector3d::UnitZ()), 0);
}

TEST(Church, HoldsNoFaceThatNobodyCanSee) {
  const TexturedScene scene = MakeScene("church", 1, kQuick);
  const TriangleMesh model = scene.Truth().model;
  int inside = 0;
  for (const auto& face : model.faces) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) center += model.vertices[static_cast<std::size_t>(face[k])] / 3;
    // Well inside the tower, where the nave's wall would end, and inside the nave.
    const bool in_tower =
        center.x() > -9.9 && center.x() < -6.1 && std::abs(center.y()) < 1.9 && center.z() < 12;
    const bool in_nave =
        center.x() > -4.7 && center.x() < 5.3 && std::abs(center.y()) < 3.4 && center.z() < 5.5;
    if (in_tower || in_nave) ++inside;
  }
  EXPECT_EQ(inside, 0);
}

TEST(Gate, HidesItsColumnsUnderWideRoofs) {
  const TexturedScene scene = MakeScene("gate", 1, kQuick);
  ExpectSound(scene);
  const TriangleMesh model = scene.Truth().model;
  const BoundingBox box = BoundsOf(model);
  EXPECT_NEAR(box.sizes().z(), 15, 0.6);
  const RayScene rays(model);
  // Straight from above, the roof; level from the south, a column at x = 2.1, y = -2.3.
  EXPECT_LT(DistanceTo(rays, {2.1, -4.2, 30}, -Eigen::Vector3d::UnitZ()), 24);
  EXPECT_NEAR(DistanceTo(rays, {2.1, -20, 3}, Eigen::Vector3d::UnitY()), 20 - 2.3 - 0.34, 0.03);
  EXPECT_GT(box.max().y(), 2.3 + 2.4);
}

TEST(Boxes, StandInARoomThatIsOpenAbove) {
  const TexturedScene scene = MakeScene("boxes", 1, kQuick);
  ExpectSound(scene);
  const BoundingBox box = BoundsOf(scene.Truth().model);
  EXPECT_NEAR(box.max().z(), 1.6, 0.05);
  EXPECT_LT(box.sizes().x(), 4.5);
  EXPECT_LT(box.sizes().y(), 4.5);
  BoundingBox room;
  std::map<int, BoundingBox> box_of_object;
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto& v = scene.mesh.vertices[static_cast<std::size_t>(scene.mesh.faces[i][k])];
      (scene.IsGround(i) ? room : box_of_object[scene.object_of_face[i]]).extend(v);
    }
  }
  EXPECT_TRUE(room.sizes().head<2>().isApprox(Eigen::Vector2d(8, 8), 1e-6));
  EXPECT_GE(box_of_object.size(), 8u);
  const RayScene rays(scene.mesh);
  EXPECT_FALSE(rays.Intersect({2.5, 2.5, 1}, Eigen::Vector3d::UnitZ(), 0, 100).has_value());
}

TEST(MakeScene, DependsOnItsSeedOnly) {
  const TexturedScene a = MakeScene("boxes", 5, kQuick), b = MakeScene("boxes", 5, kQuick);
  const TexturedScene other = MakeScene("boxes", 6, kQuick);
  ASSERT_EQ(a.mesh.vertices.size(), b.mesh.vertices.size());
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  for (std::size_t i = 0; i < a.materials.size(); ++i) {
    EXPECT_EQ(cv::norm(a.materials[i].texture_bgr, b.materials[i].texture_bgr, cv::NORM_INF), 0);
  }
  const cv::Mat &mine = a.materials[1].texture_bgr, &theirs = other.materials[1].texture_bgr;
  ASSERT_EQ(mine.size(), theirs.size());  // of the floor
  EXPECT_GT(cv::norm(mine, theirs, cv::NORM_L1) / (3.0 * static_cast<double>(mine.total())), 5);
}

TEST(MakeScene, RefusesUnknownNamesAndScales) {
  EXPECT_THROW(MakeScene("castle", 1), UsageError);
  EXPECT_NE(test::ErrorOf([] { MakeScene("castle", 1); }).find("church, boxes or gate"),
            std::string::npos);
  EXPECT_THROW(MakeScene("boxes", 1, 0.1), UsageError);
  EXPECT_THROW(MakeScene("boxes", 1, NAN), UsageError);
}

// Corners that a feature detector finds, per 1000 pixels of each object.
std::map<int, double> FeatureDensity(const TexturedScene& scene) {
  const Renderer renderer(scene, RenderOptions());
  const PinholeCamera camera{640, 368, 480, 480, 320, 184};
  std::map<int, double> pixels, corners;
  for (const NamedView& named : OverviewOf(scene)) {
    const Rigid3d pose = CamFromWorld(named.view.position, named.view.direction);
    const cv::Mat faces = renderer.RenderFaces(camera, pose);
    cv::Mat grey;
    cv::cvtColor(renderer.Render(camera, pose), grey, cv::COLOR_BGR2GRAY);
    std::vector<cv::KeyPoint> keypoints;
    cv::FAST(grey, keypoints, 20);
    const auto object_at = [&](int x, int y) {
      const int face = faces.at<int>(y, x);
      return face < 0 ? -1 : scene.object_of_face[static_cast<std::size_t>(face)];
    };
    for (int y = 0; y < grey.rows; ++y) {
      for (int x = 0; x < grey.cols; ++x) pixels[object_at(x, y)] += 1;
    }
    for (const auto& keypoint : keypoints) {
      corners[object_at(static_cast<int>(keypoint.pt.x), static_cast<int>(keypoint.pt.y))] += 1;
    }
  }
  std::map<int, double> density;
  for (const auto& [object, count] : pixels) {
    if (object >= 0 && count > 3000) density[object] = 1000 * corners[object] / count;
  }
  return density;
}

TEST(Texture, EveryPartOfTheChurchHasFeatures) {
  const auto density = FeatureDensity(MakeScene("church", 1, 3));
  EXPECT_GE(density.size(), 6u);
  for (const auto& [object, per_thousand] : density) {
    EXPECT_GT(per_thousand, 8) << "object " << object;
  }
}

TEST(Texture, EveryBoxHasFeatures) {
  const auto density = FeatureDensity(MakeScene("boxes", 1, 1.5));
  EXPECT_GE(density.size(), 8u);
  for (const auto& [object, per_thousand] : density) {
    EXPECT_GT(per_thousand, 5) << "object " << object;
  }
}

TEST(Overview, SeesTheModelFromInsideTheRoom) {
  const TexturedScene scene = MakeScene("boxes", 1, kQuick);
  const Renderer renderer(scene, test::PlainLight());
  const auto views = OverviewOf(scene);
  ASSERT_GE(views.size(), 6u);
  for (const NamedView& named : views) {
    EXPECT_LT(named.view.position.head<2>().cwiseAbs().maxCoeff(), 4) << named.name;
    const cv::Mat faces = renderer.RenderFaces(
        test::SmallCamera(), CamFromWorld(named.view.position, named.view.direction));
    int model = 0;
    for (const int face : cv::Mat_<int>(faces)) {
      if (face >= 0 && !scene.IsGround(static_cast<std::size_t>(face))) ++model;
    }
    EXPECT_GT(model, faces.rows * faces.cols / 20) << named.name;
  }
}

}  // namespace
}  // namespace colmap_ext
