#include "colmap_ext/geom/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <random>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 368;

Camera MakeCamera(CameraModel model, const std::vector<double>& params) {
  return {model, kWidth, kHeight, params};
}

// One lens of each model, with a distortion as strong as real ones have.
std::vector<Camera> CamerasOfEveryModel() {
  return {
      MakeCamera(CameraModel::kSimplePinhole, {500, 318, 186}),
      MakeCamera(CameraModel::kPinhole, {500, 510, 318, 186}),
      MakeCamera(CameraModel::kSimpleRadial, {500, 318, 186, -0.15}),
      MakeCamera(CameraModel::kRadial, {500, 318, 186, -0.2, 0.05}),
      MakeCamera(CameraModel::kOpenCV, {500, 510, 318, 186, -0.25, 0.08, 0.002, -0.003}),
      MakeCamera(CameraModel::kOpenCVFisheye, {300, 305, 318, 186, 0.05, -0.02, 0.004, -0.001}),
      MakeCamera(CameraModel::kFullOpenCV,
                 {500, 510, 318, 186, 0.3, -0.1, 0.001, 0.002, 0.02, 0.5, -0.05, 0.01}),
      MakeCamera(CameraModel::kFOV, {400, 405, 318, 186, 0.9}),
      MakeCamera(CameraModel::kSimpleRadialFisheye, {300, 318, 186, 0.03}),
      MakeCamera(CameraModel::kRadialFisheye, {300, 318, 186, 0.03, -0.01}),
      MakeCamera(CameraModel::kThinPrismFisheye,
                 {300, 305, 318, 186, 0.03, -0.01, 0.001, -0.002, 0.003, -0.001, 0.0015, -0.0005}),
  };
}

class EveryCameraModel : public testing::TestWithParam<Camera> {};

INSTANTIATE_TEST_SUITE_P(Camera, EveryCameraModel, testing::ValuesIn(CamerasOfEveryModel()),
                         [](const auto& info) {
                           return std::string(
                               GetCameraModelInfo(static_cast<int>(info.param.model)).name);
                         });

TEST_P(EveryCameraModel, PixelComesBackOverTheWholeImage) {
  const Camera& camera = GetParam();
  for (double y = 0; y <= kHeight; y += 8) {
    for (double x = 0; x <= kWidth; x += 8) {
      const Eigen::Vector2d pixel(x, y);
      const auto normalized = NormalizedFromImage(camera, pixel);
      ASSERT_TRUE(normalized.has_value()) << pixel.transpose();
      EXPECT_LT((ImageFromNormalized(camera, *normalized) - pixel).norm(), 1e-8);
    }
  }
}

TEST_P(EveryCameraModel, DerivativesAreThoseOfTheProjection) {
  const Camera& camera = GetParam();
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.31, -0.22), Eigen::Vector2d(-0.5, 0.05),
                                       Eigen::Vector2d(2e-5, 1e-5), Eigen::Vector2d(0, 0)}) {
    ProjectionDerivatives derivatives;
    const Eigen::Vector2d pixel = ImageFromNormalized(camera, point, &derivatives);
    EXPECT_LT((pixel - ImageFromNormalized(camera, point)).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      const Eigen::Vector2d numeric =
          (ImageFromNormalized(camera, point + step) - ImageFromNormalized(camera, point - step)) /
          (2 * kStep);
      EXPECT_LT((derivatives.by_normalized.col(axis) - numeric).norm(), 1e-5) << point.transpose();
    }
    for (std::size_t k = 0; k < camera.params.size(); ++k) {
      Camera more = camera, less = camera;
      more.params[k] += kStep;
      less.params[k] -= kStep;
      const Eigen::Vector2d numeric =
          (ImageFromNormalized(more, point) - ImageFromNormalized(less, point)) / (2 * kStep);
      const Eigen::Vector2d by_param = derivatives.by_params.col(static_cast<Eigen::Index>(k));
      EXPECT_LT((by_param - numeric).norm(), 1e-5) << "parameter " << k;
    }
  }
}

TEST(FovCamera, DerivativesGoThroughZeroDistortion) {
  for (const double omega : {0.0, 1e-4, 1.2e-3}) {
    const Camera camera = MakeCamera(CameraModel::kFOV, {400, 405, 318, 186, omega});
    const Eigen::Vector2d point(0.4, -0.3);
    ProjectionDerivatives derivatives;
    ImageFromNormalized(camera, point, &derivatives);
    Camera more = camera, less = camera;
    more.params[4] = omega + 1e-3;
    less.params[4] = omega - 1e-3;
    const Eigen::Vector2d numeric =
        (ImageFromNormalized(more, point) - ImageFromNormalized(less, point)) / 2e-3;
    EXPECT_LT((derivatives.by_params.col(4) - numeric).norm(), 1e-4) << omega;
  }
}

TEST_P(EveryCameraModel, NormalizedPointComesBack) {
  const Camera& camera = GetParam();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-0.55, 0.55);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d point(coordinate(random), coordinate(random));
    const auto back = NormalizedFromImage(camera, ImageFromNormalized(camera, point));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - point).norm(), 1e-10);
  }
}

TEST_P(EveryCameraModel, AxisMapsToThePrincipalPointBothWays) {
  const PinholeCamera pinhole = ToPinhole(GetParam());
  const Eigen::Vector2d principal_point(pinhole.cx, pinhole.cy);
  EXPECT_LT((ImageFromNormalized(GetParam(), {0, 0}) - principal_point).norm(), 1e-12);
  const auto back = NormalizedFromImage(GetParam(), principal_point);
  ASSERT_TRUE(back.has_value());
  EXPECT_LT(back->norm(), 1e-12);
}

TEST_P(EveryCameraModel, MappingIsSmoothNearTheAxis) {
  // The series used near r = 0 must join the formula used elsewhere.
  const Camera& camera = GetParam();
  const double near =
      (ImageFromNormalized(camera, {0.9e-9, 0}).x() - ToPinhole(camera).cx) / 0.9e-9;
  const double far = (ImageFromNormalized(camera, {1e-5, 0}).x() - ToPinhole(camera).cx) / 1e-5;
  EXPECT_NEAR(near / far, 1, 1e-3);
}

TEST_P(EveryCameraModel, WrongNumberOfParametersIsAnError) {
  Camera camera = GetParam();
  camera.params.pop_back();
  EXPECT_THROW(ImageFromNormalized(camera, {0, 0}), Error);
  EXPECT_THROW(NormalizedFromImage(camera, {0, 0}), Error);
  EXPECT_THROW(ToPinhole(camera), Error);
}

TEST_P(EveryCameraModel, NanPixelHasNoRay) {
  EXPECT_FALSE(NormalizedFromImage(GetParam(), {std::nan(""), 10}).has_value());
}

std::vector<cv::Point3d> RaysOverTheImage() {
  std::vector<cv::Point3d> rays;
  for (double y = -0.35; y <= 0.35; y += 0.05) {
    for (double x = -0.6; x <= 0.6; x += 0.05) rays.emplace_back(x, y, 1.0);
  }
  return rays;
}

cv::Matx33d OpenCVMatrix(const Camera& camera) {
  const PinholeCamera p = ToPinhole(camera);
  // OpenCV's pixel centres are at integers: half a pixel less.
  return {p.fx, 0, p.cx - 0.5, 0, p.fy, p.cy - 0.5, 0, 0, 1};
}

void ExpectSamePixels(const Camera& camera, const std::vector<cv::Point3d>& rays,
                      const std::vector<cv::Point2d>& opencv_pixels) {
  ASSERT_EQ(rays.size(), opencv_pixels.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector2d ours = ImageFromNormalized(camera, {rays[i].x, rays[i].y});
    EXPECT_NEAR(ours.x(), opencv_pixels[i].x + 0.5, 1e-9);
    EXPECT_NEAR(ours.y(), opencv_pixels[i].y + 0.5, 1e-9);
  }
}

TEST(CameraAgainstOpenCV, PerspectiveModelsMatchProjectPoints) {
  const std::vector<cv::Point3d> rays = RaysOverTheImage();
  for (const Camera& camera : CamerasOfEveryModel()) {
    const std::vector<double>& p = camera.params;
    std::vector<double> coefficients;
    if (camera.model == CameraModel::kSimpleRadial) coefficients = {p[3], 0, 0, 0};
    if (camera.model == CameraModel::kRadial) coefficients = {p[3], p[4], 0, 0};
    if (camera.model == CameraModel::kOpenCV) coefficients = {p[4], p[5], p[6], p[7]};
    if (camera.model == CameraModel::kFullOpenCV) {
      coefficients = {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
    }
    if (coefficients.empty()) continue;
    SCOPED_TRACE(GetCameraModelInfo(static_cast<int>(camera.model)).name);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(rays, cv::Vec3d(), cv::Vec3d(), OpenCVMatrix(camera), coefficients, pixels);
    ExpectSamePixels(camera, rays, pixels);
  }
}

TEST(CameraAgainstOpenCV, FisheyeModelsMatchFisheyeProjectPoints) {
  const std::vector<cv::Point3d> rays = RaysOverTheImage();
  int compared = 0;
  for (const Camera& camera : CamerasOfEveryModel()) {
    const std::vector<double>& p = camera.params;
    cv::Vec4d coefficients;
    if (camera.model == CameraModel::kSimpleRadialFisheye) {
      coefficients = {p[3], 0, 0, 0};
    } else if (camera.model == CameraModel::kRadialFisheye) {
      coefficients = {p[3], p[4], 0, 0};
    } else if (camera.model == CameraModel::kOpenCVFisheye) {
      coefficients = {p[4], p[5], p[6], p[7]};
    } else {
      continue;
    }
    SCOPED_TRACE(GetCameraModelInfo(static_cast<int>(camera.model)).name);
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(rays, pixels, cv::Vec3d(), cv::Vec3d(), OpenCVMatrix(camera),
                               coefficients);
    ExpectSamePixels(camera, rays, pixels);
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

TEST(Camera, ThinPrismFisheyeWithoutPrismAndDecentringIsOpenCVFisheye) {
  const Camera prism = MakeCamera(CameraModel::kThinPrismFisheye,
                                  {300, 305, 318, 186, 0.05, -0.02, 0, 0, 0.004, -0.001, 0, 0});
  const Camera fisheye =
      MakeCamera(CameraModel::kOpenCVFisheye, {300, 305, 318, 186, 0.05, -0.02, 0.004, -0.001});
  for (const cv::Point3d& ray : RaysOverTheImage()) {
    const Eigen::Vector2d point(ray.x, ray.y);
    EXPECT_LT((ImageFromNormalized(prism, point) - ImageFromNormalized(fisheye, point)).norm(),
              1e-12);
  }
}

TEST(Camera, ThinPrismFisheyeFollowsItsFormula) {
  const Camera camera = CamerasOfEveryModel().back();
  const std::vector<double>& p = camera.params;
  const double u = 0.3, v = -0.2;
  const double angle = std::atan(std::hypot(u, v));
  const double uu = u * angle / std::hypot(u, v), vv = v * angle / std::hypot(u, v);
  const double r2 = uu * uu + vv * vv;
  const double radial =
      p[4] * r2 + p[5] * r2 * r2 + p[8] * std::pow(r2, 3) + p[9] * std::pow(r2, 4);
  const double x = uu + uu * radial + 2 * p[6] * uu * vv + p[7] * (r2 + 2 * uu * uu) + p[10] * r2;
  const double y = vv + vv * radial + 2 * p[7] * uu * vv + p[6] * (r2 + 2 * vv * vv) + p[11] * r2;
  const Eigen::Vector2d pixel = ImageFromNormalized(camera, {u, v});
  EXPECT_NEAR(pixel.x(), p[0] * x + p[2], 1e-10);
  EXPECT_NEAR(pixel.y(), p[1] * y + p[3], 1e-10);
}

TEST(Camera, FovModelFollowsItsFormula) {
  const Camera camera = MakeCamera(CameraModel::kFOV, {400, 405, 318, 186, 0.9});
  const double r = 0.5;
  const double distorted = std::atan(2 * r * std::tan(0.45)) / 0.9;
  EXPECT_NEAR(ImageFromNormalized(camera, {r, 0}).x(), 400 * distorted + 318, 1e-10);
  // Beyond atan's range there is no ray.
  EXPECT_FALSE(NormalizedFromImage(camera, {400 * 1.8 + 318, 186}).has_value());
}

TEST(Camera, BeyondTheFoldOfThePolynomialThereIsNoRay) {
  // r (1 - 0.3 r²) is largest at r = 1.054, where it is 0.703.
  const Camera camera = MakeCamera(CameraModel::kSimpleRadial, {100, 320, 184, -0.3});
  EXPECT_TRUE(NormalizedFromImage(camera, {320 + 70, 184}).has_value());
  EXPECT_FALSE(NormalizedFromImage(camera, {320 + 71, 184}).has_value());
  EXPECT_FALSE(NormalizedFromImage(camera, {320 + 300, 184}).has_value());
}

TEST(Camera, TheSolutionBeforeTheFoldIsTheOneReturned) {
  const Camera camera = MakeCamera(CameraModel::kRadial, {100, 320, 184, -0.6, 0.12});
  // 1 - 1.8 r² + 0.6 r⁴ = 0 at r = 0.860: everything returned must be nearer than that.
  int found = 0;
  for (double x = 0; x < 80; x += 0.5) {
    const auto point = NormalizedFromImage(camera, {320 + x, 184});
    if (!point) continue;
    EXPECT_LT(point->norm(), 0.861) << x;
    ++found;
  }
  EXPECT_GT(found, 80);  // r (1 - 0.6 r² + 0.12 r⁴) is 0.535 there: 107 steps
}

TEST(Camera, FisheyeAtARightAngleHasNoRay) {
  const Camera camera = MakeCamera(CameraModel::kSimpleRadialFisheye, {100, 320, 184, 0});
  EXPECT_TRUE(NormalizedFromImage(camera, {320 + 157, 184}).has_value());
  EXPECT_FALSE(NormalizedFromImage(camera, {320 + 157.1, 184}).has_value());
}

TEST(Camera, KnowsAllModelsByIdAndByName) {
  for (int id = 0; id <= 10; ++id) {
    const CameraModelInfo& info = GetCameraModelInfo(id);
    EXPECT_EQ(static_cast<int>(info.model), id);
    EXPECT_EQ(&GetCameraModelInfo(std::string(info.name)), &info);
  }
}

TEST(Camera, UnknownModelIsAnErrorThatNamesIt) {
  for (const int id : {-1, 11, 100000}) {
    try {
      GetCameraModelInfo(id);
      FAIL() << id;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(std::to_string(id)), std::string::npos);
    }
  }
  EXPECT_THROW(GetCameraModelInfo("PINHOLE2"), Error);
  EXPECT_THROW(GetCameraModelInfo(""), Error);
}

TEST(Camera, OnlyPerspectiveCamerasWithoutDistortionArePinholes) {
  for (const Camera& camera : CamerasOfEveryModel()) {
    EXPECT_EQ(IsPinhole(camera),
              camera.model == CameraModel::kPinhole || camera.model == CameraModel::kSimplePinhole);
  }
  EXPECT_TRUE(IsPinhole(MakeCamera(CameraModel::kSimpleRadial, {500, 320, 184, 0})));
  EXPECT_TRUE(IsPinhole(MakeCamera(CameraModel::kOpenCV, {500, 500, 320, 184, 0, 0, 0, 0})));
  EXPECT_TRUE(IsPinhole(MakeCamera(CameraModel::kFOV, {500, 500, 320, 184, 0})));
  EXPECT_FALSE(IsPinhole(MakeCamera(CameraModel::kSimpleRadialFisheye, {500, 320, 184, 0})));
}

TEST(Camera, PinholeOfAModelWithoutDistortionProjectsTheSame) {
  const Camera camera = MakeCamera(CameraModel::kOpenCV, {500, 510, 318, 186, 0, 0, 0, 0});
  const PinholeCamera pinhole = ToPinhole(camera);
  const Camera back = ToCamera(pinhole);
  EXPECT_EQ(back.model, CameraModel::kPinhole);
  EXPECT_EQ(back.width, kWidth);
  EXPECT_EQ(back.height, kHeight);
  const Eigen::Vector3d point(0.4, -0.3, 2);
  EXPECT_LT((pinhole.Project(point) - ImageFromNormalized(camera, point.hnormalized())).norm(),
            1e-12);
  EXPECT_LT((pinhole.Project(point) - ImageFromNormalized(back, point.hnormalized())).norm(),
            1e-12);
}

TEST(Camera, ScalingKeepsThePlaceInThePicture) {
  const PinholeCamera low{640, 368, 500, 510, 318, 186};
  const PinholeCamera high = ScaleTo(low, 1280, 1104);
  EXPECT_EQ(high.width, 1280);
  EXPECT_EQ(high.height, 1104);
  const Eigen::Vector3d point(0.4, -0.3, 2);
  const Eigen::Vector2d scaled = low.Project(point).cwiseProduct(Eigen::Vector2d(2, 3));
  EXPECT_LT((high.Project(point) - scaled).norm(), 1e-10);
}

}  // namespace
}  // namespace colmap_ext
