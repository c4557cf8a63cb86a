#include "colmap_ext/geom/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace colmap_ext {
namespace {

TEST(Geodesy, AxesPointEastNorthUp) {
  const GeoPosition origin{47.0, 8.0, 400.0};
  const Eigen::Vector3d east = EnuFromGeo(origin, {47.0, 8.001, 400.0});
  EXPECT_GT(east.x(), 70.0);
  EXPECT_NEAR(east.y(), 0.0, 0.01);
  const Eigen::Vector3d north = EnuFromGeo(origin, {47.001, 8.0, 400.0});
  EXPECT_NEAR(north.y(), 111.2, 0.5);  // a degree of latitude is 111.2 km there
  EXPECT_TRUE(EnuFromGeo(origin, {47.0, 8.0, 410.0}).isApprox(Eigen::Vector3d(0, 0, 10), 1e-6));
}

TEST(Geodesy, RoundTrip) {
  const GeoPosition origin{-33.9, 151.2, 20.0};
  const Eigen::Vector3d point(123.4, -567.8, 90.1);
  EXPECT_LT((EnuFromGeo(origin, GeoFromEnu(origin, point)) - point).norm(), 1e-6);
}

TEST(Geodesy, Validity) {
  EXPECT_TRUE(IsValid({90, -180, -5}));
  EXPECT_FALSE(IsValid({90.1, 0, 0}));
  EXPECT_FALSE(IsValid({0, 181, 0}));
  EXPECT_FALSE(IsValid({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
}

}  // namespace
}  // namespace colmap_ext
