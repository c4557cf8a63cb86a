#include "colmap_ext/surface/point_normals.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "colmap_ext/util/error.h"
#include "surface/sampled_shapes.h"

namespace colmap_ext {
namespace {

PosedPhoto PhotoTowards(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d d = (target - position).normalized();
  PosedPhoto photo;
  photo.camera = {640, 368, 467.0, 467.0, 320.0, 184.0};
  photo.cam_from_world = CamFromWorld(position, {std::atan2(d.x(), d.y()), std::asin(d.z())});
  return photo;
}

std::vector<PosedPhoto> Around(const Eigen::Vector3d& center, double distance) {
  std::vector<PosedPhoto> photos;
  for (const Eigen::Vector3d& side :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 1, 0),
        Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0.1, 1), Eigen::Vector3d(0, 0.1, -1)}) {
    photos.push_back(PhotoTowards(center + distance * side, center));
  }
  return photos;
}

OrientedPoints WithoutNormals(OrientedPoints points) {
  for (OrientedPoint& point : points) point.normal.setZero();
  return points;
}

TEST(EstimateNormals, OfASphereLookOutwards) {
  const Eigen::Vector3d center(100, 0, 0);
  const OrientedPoints truth = SpherePoints(center, 4, 4000, 0.0);
  OrientedPoints points = WithoutNormals(truth);
  EstimateNormals(Around(center, 20), 16, &points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].normal.norm(), 1, 1e-9);
    EXPECT_GT(points[i].normal.dot(truth[i].normal), 0.95);
  }
}

TEST(EstimateNormals, LookAtThePhotoThatHasThePoint) {
  OrientedPoints points;
  AppendPlane(0, 0, 10, 10, 0, 0.5, -1, &points);
  points = WithoutNormals(points);
  // The nearest photo is above but looks up and away; the one below sees the plane.
  const std::vector<PosedPhoto> photos = {PhotoTowards({5, 5, 3}, {5, 6, 30}),
                                          PhotoTowards({5, 4, -20}, {5, 5, 0})};
  EstimateNormals(photos, 10, &points);
  for (const OrientedPoint& point : points) EXPECT_LT(point.normal.z(), -0.99);
}

TEST(EstimateNormals, SameWhateverTheThreads) {
  OrientedPoints parallel = WithoutNormals(SpherePoints({0, 0, 0}, 2, 800, 0.01));
  OrientedPoints serial = parallel;
  EstimateNormals(Around({0, 0, 0}, 9), 12, &parallel);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EstimateNormals(Around({0, 0, 0}, 9), 12, &serial);
  for (std::size_t i = 0; i < serial.size(); ++i) {
    EXPECT_EQ(serial[i].normal, parallel[i].normal);
  }
}

TEST(EstimateNormals, BadInputIsRefused) {
  OrientedPoints points = SpherePoints({0, 0, 0}, 2, 10, 0);
  EXPECT_THROW(EstimateNormals(Around({0, 0, 0}, 9), 16, &points), Error);
  EXPECT_THROW(EstimateNormals(Around({0, 0, 0}, 9), 2, &points), Error);
  EXPECT_THROW(EstimateNormals({}, 5, &points), Error);
}

}  // namespace
}  // namespace colmap_ext
