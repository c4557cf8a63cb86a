#include "colmap_ext/dense/epipolar_frame.h"

#include <gtest/gtest.h>

#include <vector>

#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

const PinholeCamera kCamera{640, 360, 480, 470, 322, 178};

struct Motion {
  const char* name;
  Eigen::Vector3d step;  // of the partner, in the reference's frame
  double turn_rad;       // of the partner, about its vertical
  bool is_planar;
};

const std::vector<Motion> kMotions = {
    {"sideways", {2, 0.1, 0}, -0.1, true},   {"to the left", {-2, 0, 0.3}, 0.05, true},
    {"upwards", {0.1, -1.5, 0}, 0.02, true}, {"oblique", {1, 0.8, 0.4}, -0.1, true},
    {"forward", {0.1, 0, 3}, 0, false},      {"backward", {0, 0.2, -3}, 0.1, false},
};

Rigid3d PartnerFromReference(const Motion& motion) {
  Rigid3d partner_from_reference;
  partner_from_reference.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(motion.turn_rad, Eigen::Vector3d::UnitY()));
  partner_from_reference.translation = -(partner_from_reference.rotation * motion.step);
  return partner_from_reference;
}

TEST(EpipolarFrame, BothPhotosShowAPointInTheSameRowAndSlopesGiveItsDistance) {
  const Rigid3d reference_from_world = CamFromWorld({3, 4, 5}, {0.7, -0.3});
  for (const Motion& motion : kMotions) {
    SCOPED_TRACE(motion.name);
    const Rigid3d partner_from_reference = PartnerFromReference(motion);
    const EpipolarFrame frame(kCamera, reference_from_world,
                              partner_from_reference * reference_from_world);
    EXPECT_EQ(frame.is_planar(), motion.is_planar);
    EXPECT_NEAR(frame.baseline(), motion.step.norm(), 1e-9);
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(1.5, -2, 12), Eigen::Vector3d(-3, 1, 9), Eigen::Vector3d(2, 2.5, 30)}) {
      const Eigen::Vector3d in_rect = frame.FromReference(point);
      const Eigen::Vector3d baseline = Eigen::Vector3d::UnitX() * frame.baseline();
      const Eigen::Vector3d from_partner = in_rect - baseline;
      // The same direction as the partner sees it.
      EXPECT_LT((frame.ToPartner(from_partner) - partner_from_reference * point).norm(), 1e-9);
      const Eigen::Vector2d a = frame.Position(in_rect);
      const Eigen::Vector2d b = frame.Position(from_partner);
      EXPECT_NEAR(a.y(), b.y(), 1e-9);
      const double rho = in_rect.tail<2>().norm();
      EXPECT_NEAR(frame.Slope(a.x(), a.y()) - frame.Slope(b.x(), b.y()), frame.baseline() / rho,
                  1e-9);
      EXPECT_GT(a.x(), b.x());
    }
  }
}

TEST(EpipolarFrame, PositionsAndDirectionsAreInverse) {
  for (const Motion& motion : kMotions) {
    SCOPED_TRACE(motion.name);
    const EpipolarFrame frame(kCamera, Rigid3d(), PartnerFromReference(motion));
    for (const Eigen::Vector2d& position : {Eigen::Vector2d(30, -20), Eigen::Vector2d(-111, 90)}) {
      const Eigen::Vector3d direction = frame.Direction(position.x(), position.y());
      EXPECT_LT((frame.Position(direction) - position).norm(), 1e-9);
      EXPECT_LT((frame.FromReference(frame.ToReference(direction)) - direction).norm(), 1e-9);
      const double slope = frame.Slope(position.x(), position.y());
      EXPECT_NEAR(slope, direction.x() / direction.tail<2>().norm(), 1e-12);
      EXPECT_NEAR(frame.Column(slope, position.y()), position.x(), 1e-9);
    }
  }
}

TEST(EpipolarFrame, HoldsTheWholePhoto) {
  for (const Motion& motion : kMotions) {
    SCOPED_TRACE(motion.name);
    const EpipolarFrame frame(kCamera, Rigid3d(), PartnerFromReference(motion));
    for (double u = 0.5; u < kCamera.width; u += 40) {
      for (double v = 0.5; v < kCamera.height; v += 40) {
        const Eigen::Vector2d position = frame.Position(frame.FromReference(kCamera.Ray({u, v})));
        EXPECT_TRUE((position.array() >= frame.min_position().array() - 5).all());
        EXPECT_TRUE((position.array() <= frame.max_position().array() + 5).all());
      }
    }
  }
}

TEST(EpipolarFrame, RefusesPhotosFromOnePlace) {
  Rigid3d turned;
  turned.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  ExpectError([&] { EpipolarFrame(kCamera, Rigid3d(), turned); }, {"same place"});
}

}  // namespace
}  // namespace colmap_ext
