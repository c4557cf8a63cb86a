#include "colmap_ext/geom/transforms.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

class TransformsTest : public testing::Test {
 protected:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d Point() { return {Uniform(-9, 9), Uniform(-9, 9), Uniform(-9, 9)}; }
  Eigen::Quaterniond Rotation() {
    return Eigen::Quaterniond(Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1), Uniform(0.1, 1))
        .normalized();
  }

  std::mt19937 random_{42};
};

TEST_F(TransformsTest, RigidComposesAndInverts) {
  for (int i = 0; i < 100; ++i) {
    const Rigid3d b_from_a{Rotation(), Point()};
    const Rigid3d c_from_b{Rotation(), Point()};
    const Eigen::Vector3d point = Point();
    EXPECT_TRUE(((c_from_b * b_from_a) * point).isApprox(c_from_b * (b_from_a * point), 1e-12));
    EXPECT_TRUE((Inverse(b_from_a) * (b_from_a * point)).isApprox(point, 1e-12));
  }
}

TEST_F(TransformsTest, SimilarityComposesAndInverts) {
  for (int i = 0; i < 100; ++i) {
    const Sim3d b_from_a{Uniform(0.1, 5), Rotation(), Point()};
    const Sim3d c_from_b{Uniform(0.1, 5), Rotation(), Point()};
    const Eigen::Vector3d point = Point();
    EXPECT_TRUE(((c_from_b * b_from_a) * point).isApprox(c_from_b * (b_from_a * point), 1e-12));
    EXPECT_TRUE((Inverse(b_from_a) * (b_from_a * point)).isApprox(point, 1e-11));
  }
}

TEST_F(TransformsTest, MovedCameraSeesMovedPointsInTheSameDirection) {
  for (int i = 0; i < 100; ++i) {
    const Sim3d new_from_old{Uniform(0.1, 5), Rotation(), Point()};
    const Rigid3d cam_from_old{Rotation(), Point()};
    const Eigen::Vector3d point = Point();
    const Rigid3d cam_from_new = TransformCameraWorld(new_from_old, cam_from_old);
    EXPECT_TRUE((cam_from_new * (new_from_old * point))
                    .isApprox(new_from_old.scale * (cam_from_old * point), 1e-10));
    EXPECT_TRUE(
        CameraCenter(cam_from_new).isApprox(new_from_old * CameraCenter(cam_from_old), 1e-10));
  }
}

TEST_F(TransformsTest, EstimatesAnExactSimilarity) {
  Eigen::Matrix3Xd source(3, 8);
  Eigen::Matrix3Xd target(3, 8);
  const Sim3d truth{2.5, Rotation(), Point()};
  for (int i = 0; i < 8; ++i) {
    source.col(i) = Point();
    target.col(i) = truth * Eigen::Vector3d(source.col(i));
  }
  const Sim3d found = EstimateSimilarity(source, target);
  EXPECT_NEAR(found.scale, truth.scale, 1e-12);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 1e-7);
  EXPECT_TRUE(found.translation.isApprox(truth.translation, 1e-10));
}

TEST_F(TransformsTest, RefusesALineOfPoints) {
  Eigen::Matrix3Xd line(3, 5);
  for (int i = 0; i < 5; ++i) line.col(i) = Eigen::Vector3d(i, 2.0 * i, 1.0);
  EXPECT_THROW(EstimateSimilarity(line, line), Error);
  EXPECT_THROW(EstimateSimilarity(line.leftCols(2), line.leftCols(2)), Error);
}

TEST(ViewDirection, NorthEastAndPitch) {
  using std::numbers::pi;
  EXPECT_TRUE(DirectionInWorld({0, 0}).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_TRUE(DirectionInWorld({pi / 2, 0}).isApprox(Eigen::Vector3d::UnitX(), 1e-15));
  EXPECT_TRUE(DirectionInWorld({1.0, pi / 2}).isApprox(Eigen::Vector3d::UnitZ(), 1e-15));
  EXPECT_LT(DirectionInWorld({0, DegToRad(-30)}).z(), 0) << "negative pitch looks down";
}

TEST(ViewDirection, CameraLooksForwardWithLevelImage) {
  const Eigen::Vector3d position(3, -2, 7);
  for (const double yaw : {-3.0, -1.0, 0.0, 0.7, 2.9}) {
    for (const double pitch : {-1.5, -0.5, 0.0, 0.5, 1.5}) {
      const ViewDirection direction{yaw, pitch};
      const Rigid3d cam_from_world = CamFromWorld(position, direction);
      EXPECT_TRUE(CameraCenter(cam_from_world).isApprox(position, 1e-12));
      const Eigen::Vector3d ahead = cam_from_world * (position + DirectionInWorld(direction));
      EXPECT_TRUE(ahead.isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
      const Eigen::Vector3d above = cam_from_world * (position + Eigen::Vector3d::UnitZ());
      EXPECT_NEAR(above.x(), 0, 1e-12) << "the image is level";
      EXPECT_LT(above.y(), 0) << "up in the world is up in the image";
      const ViewDirection back = ViewDirectionOf(cam_from_world);
      EXPECT_NEAR(back.yaw_rad, yaw, 1e-9);
      EXPECT_NEAR(back.pitch_rad, pitch, 1e-7);
    }
  }
}

TEST(ViewDirection, YawSurvivesLookingStraightDown) {
  const Rigid3d cam_from_world =
      CamFromWorld(Eigen::Vector3d::Zero(), {0.8, -std::numbers::pi / 2});
  EXPECT_NEAR(ViewDirectionOf(cam_from_world).yaw_rad, 0.8, 1e-9);
}

TEST(NormalizeAngle, StaysInRange) {
  using std::numbers::pi;
  EXPECT_NEAR(NormalizeAngle(3 * pi), pi, 1e-12);
  EXPECT_NEAR(NormalizeAngle(-pi), pi, 1e-12);
  EXPECT_NEAR(NormalizeAngle(-7.0), -7.0 + 2 * pi, 1e-12);
}

}  // namespace
}  // namespace colmap_ext
