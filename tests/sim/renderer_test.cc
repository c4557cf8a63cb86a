#include "colmap_ext/sim/renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/geom/ray_scene.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::AddCube;
using test::AddQuad;
using test::FlatMaterial;
using test::GroundScene;
using test::LookingDown;
using test::PlainLight;
using test::SmallCamera;

double MeanGrey(const cv::Mat& picture, const Eigen::Vector2d& pixel, int radius = 3) {
  const cv::Rect area(static_cast<int>(pixel.x()) - radius, static_cast<int>(pixel.y()) - radius,
                      2 * radius + 1, 2 * radius + 1);
  return cv::mean(picture(area))[1];
}

TEST(RenderDepth, PlaneSeenObliquelyIsExact) {
  const Renderer renderer(GroundScene(FlatMaterial(128)), PlainLight());
  const PinholeCamera camera = SmallCamera();
  const Eigen::Vector3d center(1.5, -4, 6.25);
  const Rigid3d pose = CamFromWorld(center, {DegToRad(30), DegToRad(-50)});
  const cv::Mat depth = renderer.RenderDepth(camera, pose);
  ASSERT_EQ(depth.type(), CV_32FC1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = pose.rotation.conjugate() * camera.Ray({x + 0.5, y + 0.5});
      ASSERT_NEAR(depth.at<float>(y, x), -center.z() / ray.z(), 1e-5);
    }
  }
}

TEST(RenderDepth, CubeFaceIsAtItsDistanceAndSkyIsZero) {
  TexturedScene scene;
  scene.materials.push_back(FlatMaterial(128));
  AddCube({-1, 10, -1}, 2, 0, 1, &scene);
  const Renderer renderer(scene, PlainLight());
  const PinholeCamera camera = SmallCamera();
  const cv::Mat depth = renderer.RenderDepth(camera, CamFromWorld({0, 0, 0}, {0, 0}));
  // The near face spans 2 m at 10 m: 24 px around the principal point.
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double dx = std::abs(x + 0.5 - camera.cx), dy = std::abs(y + 0.5 - camera.cy);
      if (dx < 11.9 && dy < 11.9) {
        EXPECT_NEAR(depth.at<float>(y, x), 10, 1e-5);
      } else if (dx > 12.1 || dy > 12.1) {
        EXPECT_EQ(depth.at<float>(y, x), 0);
      }
    }
  }
}

TEST(RenderFaces, AgreesWithSingleRays) {
  TexturedScene scene = GroundScene(FlatMaterial(128));
  AddCube({-1, 4, 0}, 2, 0, 1, &scene);
  AddCube({2, 6, 0.5}, 1, 0, 2, &scene);
  const Renderer renderer(scene, PlainLight());
  const RayScene rays(scene.mesh);
  const PinholeCamera camera = SmallCamera();
  const Rigid3d pose = CamFromWorld({0.3, -3, 3}, {DegToRad(8), DegToRad(-20)});
  const cv::Mat faces = renderer.RenderFaces(camera, pose);
  int differing = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = pose.rotation.conjugate() * camera.Ray({x + 0.5, y + 0.5});
      const auto hit = rays.Intersect(CameraCenter(pose), ray.normalized(), 0, 1e4);
      if (faces.at<int>(y, x) != (hit ? hit->face : -1)) ++differing;
    }
  }
  EXPECT_LE(differing, 3);  // rays through an edge may go either way
}

// A dark ground with one bright dot: its centre must come out where Project() says.
TEST(Render, PixelConventionIsColmaps) {
  const int size = 2000;  // 2 cm a texel
  for (const Eigen::Vector2d& dot :
       {Eigen::Vector2d(0.13, 0.27), Eigen::Vector2d(-2.4, 1.1), Eigen::Vector2d(3.3, -1.7)}) {
    Material material;
    material.name = "dot";
    material.texture_bgr = cv::Mat(size, size, CV_8UC3, cv::Scalar::all(0));
    // OpenCV's circle counts from texel centres; four bits of fraction.
    const double u = (dot.x() + 20) / 40 * size - 0.5, v = (20 - dot.y()) / 40 * size - 0.5;
    cv::circle(material.texture_bgr,
               {static_cast<int>(std::lround(u * 16)), static_cast<int>(std::lround(v * 16))},
               10 * 16, cv::Scalar::all(255), -1, cv::LINE_AA, 4);
    const Renderer renderer(GroundScene(material), PlainLight());
    const PinholeCamera camera{160, 92, 120, 120, 79.3, 46.8};
    const Rigid3d pose = LookingDown({0.4, -0.2, 8});
    const cv::Mat picture = renderer.Render(camera, pose);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0;
    for (int y = 0; y < picture.rows; ++y) {
      for (int x = 0; x < picture.cols; ++x) {
        // Black ground is not quite black: there is a little haze.
        const double grey = picture.at<cv::Vec3b>(y, x)[1];
        const double w = grey < 40 ? 0 : grey;
        sum += w * Eigen::Vector2d(x + 0.5, y + 0.5);
        weight += w;
      }
    }
    ASSERT_GT(weight, 0);
    const Eigen::Vector2d expected = camera.Project(pose * Eigen::Vector3d(dot.x(), dot.y(), 0));
    EXPECT_LT((sum / weight - expected).norm(), 0.1);
  }
}

TEST(Render, SameForAnyNumberOfThreads) {
  TexturedScene scene = GroundScene(FlatMaterial(120));
  AddCube({-1, 4, 0}, 2, 0, 1, &scene);
  RenderOptions options;
  options.sensor_noise_sigma = 2;
  const Renderer renderer(scene, options);
  const Rigid3d pose = CamFromWorld({0, -3, 3}, {0, DegToRad(-20)});
  cv::Mat one, many;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = renderer.Render(SmallCamera(), pose, 7);
  }
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 8);
    many = renderer.Render(SmallCamera(), pose, 7);
  }
  EXPECT_EQ(cv::norm(one, many, cv::NORM_INF), 0);
}

TEST(Render, BlockCastsShadowAwayFromTheSun) {
  TexturedScene scene = GroundScene(FlatMaterial(128));
  AddCube({-1, -1, 0}, 2, 0, 1, &scene);
  RenderOptions options;
  options.sun_azimuth_deg = 90;  // in the east: the shadow falls to the west
  options.sun_elevation_deg = 45;
  const PinholeCamera camera = SmallCamera();
  const Rigid3d pose = LookingDown({0, 0, 12});
  const Eigen::Vector2d west = camera.Project(pose * Eigen::Vector3d(-2, 0, 0));
  const Eigen::Vector2d east = camera.Project(pose * Eigen::Vector3d(2.5, 0, 0));
  const cv::Mat lit = Renderer(scene, options).Render(camera, pose);
  EXPECT_LT(MeanGrey(lit, west), 0.7 * MeanGrey(lit, east));
  options.shadows = false;
  const cv::Mat without = Renderer(scene, options).Render(camera, pose);
  EXPECT_NEAR(MeanGrey(without, west), MeanGrey(without, east), 12);
}

TEST(Render, WallTowardsTheSunIsBrighter) {
  TexturedScene scene;
  scene.materials.push_back(FlatMaterial(128));
  AddCube({-1, -1, 0}, 2, 0, 1, &scene);
  RenderOptions options;
  options.sun_azimuth_deg = 180;
  options.sun_elevation_deg = 30;
  const Renderer renderer(scene, options);
  const PinholeCamera camera = SmallCamera();
  const cv::Mat south = renderer.Render(camera, CamFromWorld({0, -6, 1}, {0, 0}));
  const cv::Mat north = renderer.Render(camera, CamFromWorld({0, 6, 1}, {M_PI, 0}));
  EXPECT_GT(MeanGrey(south, {80, 46}), 1.4 * MeanGrey(north, {80, 46}));
}

TEST(Render, CornerBetweenWallsGetsLessSky) {
  TexturedScene scene = GroundScene(FlatMaterial(128));
  // Two walls in small pieces (light is known at vertices) that meet at x = y = 0.
  for (int i = 0; i < 10; ++i) {
    AddQuad({0.2 * i, 0, 0}, {0.2, 0, 0}, {0, 0, 2}, 0, 1, &scene);
    AddQuad({0, -0.2 * i - 0.2, 0}, {0, 0.2, 0}, {0, 0, 2}, 0, 1, &scene);
  }
  RenderOptions options;
  options.sun_strength = 0;
  const Renderer renderer(scene, options);
  const PinholeCamera camera = SmallCamera();
  const Rigid3d pose = CamFromWorld({1.5, -6, 1.8}, {DegToRad(-5), 0});
  const cv::Mat picture = renderer.Render(camera, pose);
  const double inner = MeanGrey(picture, camera.Project(pose * Eigen::Vector3d(0.1, 0, 1.5)), 1);
  const double outer = MeanGrey(picture, camera.Project(pose * Eigen::Vector3d(1.8, 0, 1.5)), 1);
  EXPECT_LT(inner, 0.93 * outer);
}

TEST(Render, FineStripesFarAwayAverageOut) {
  Material stripes;
  stripes.name = "stripes";
  stripes.texture_bgr = cv::Mat(512, 512, CV_8UC3, cv::Scalar::all(40));
  for (int x = 0; x < 512; x += 2) stripes.texture_bgr.col(x).setTo(cv::Scalar::all(220));
  TexturedScene scene;
  scene.materials.push_back(stripes);
  for (int i = -8; i < 8; ++i) {  // 1 mm stripes; a pixel is 6 cm
    AddQuad({0.5 * i, 8, -2}, {0.5, 0, 0}, {0, 0, 4}, 0, 1, &scene);
  }
  const Renderer renderer(scene, PlainLight());
  const cv::Mat picture = renderer.Render(SmallCamera(), CamFromWorld({0, 0, 0}, {0.01, 0}));
  cv::Scalar mean, deviation;
  cv::meanStdDev(picture(cv::Rect(50, 30, 60, 30)), mean, deviation);
  EXPECT_LT(deviation[1], 2.5);
}

TEST(Render, SensorNoiseHasItsSigmaAndFollowsItsSeed) {
  RenderOptions options = PlainLight();
  const TexturedScene scene = GroundScene(FlatMaterial(128));
  const Rigid3d pose = LookingDown({0, 0, 5});
  const cv::Mat clean = Renderer(scene, options).Render(SmallCamera(), pose, 1);
  options.sensor_noise_sigma = 4;
  const Renderer renderer(scene, options);
  const cv::Mat noisy = renderer.Render(SmallCamera(), pose, 1);
  cv::Mat difference;
  cv::subtract(noisy, clean, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(difference.reshape(1), mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.15);
  EXPECT_NEAR(deviation[0], 4, 0.2);
  EXPECT_EQ(cv::norm(noisy, renderer.Render(SmallCamera(), pose, 1), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(noisy, renderer.Render(SmallCamera(), pose, 2), cv::NORM_INF), 0);
}

TEST(Render, MotionBlursAlongTheMotionOnly) {
  Material halves;
  halves.name = "halves";
  halves.texture_bgr = cv::Mat(4, 400, CV_8UC3, cv::Scalar::all(0));
  halves.texture_bgr.colRange(200, 400).setTo(cv::Scalar::all(255));  // edge at x = 0
  RenderOptions options = PlainLight();
  options.samples_per_pixel = 16;
  options.shutter_s = 0.1;
  const Renderer renderer(GroundScene(halves), options);
  const Rigid3d pose = LookingDown({0, 0, 6});
  const auto grey_columns = [](const cv::Mat& picture) {
    int count = 0;
    for (int x = 0; x < picture.cols; ++x) {
      const int value = picture.at<cv::Vec3b>(46, x)[1];
      if (value > 30 && value < 150) ++count;
    }
    return count;
  };
  const int still = grey_columns(renderer.Render(SmallCamera(), pose));
  CameraMotion along, across;
  along.velocity_in_world = {5, 0, 0};  // 0.5 m during the exposure: 10 px
  across.velocity_in_world = {0, 5, 0};
  EXPECT_GE(grey_columns(renderer.Render(SmallCamera(), pose, 0, along)), still + 3);
  EXPECT_EQ(grey_columns(renderer.Render(SmallCamera(), pose, 0, across)), still);
  CameraMotion turning;
  turning.angular_rate_in_cam = {0, 0.8, 0};
  EXPECT_GE(grey_columns(renderer.Render(SmallCamera(), pose, 0, turning)), still + 3);
}

TEST(Render, MoreSamplesComeCloserToTheTruth) {
  TexturedScene scene = GroundScene(FlatMaterial(200));
  AddCube({-1, 4, 0.5}, 2, 0, 1, &scene);
  const Rigid3d pose = CamFromWorld({0.2, -3, 2}, {0.1, DegToRad(-8)});
  const auto with = [&](int samples) {
    RenderOptions options;
    options.samples_per_pixel = samples;
    return Renderer(scene, options).Render(SmallCamera(), pose);
  };
  const cv::Mat truth = with(64);
  const double one = cv::norm(with(1), truth, cv::NORM_L2);
  const double four = cv::norm(with(4), truth, cv::NORM_L2);
  const double nine = cv::norm(with(9), truth, cv::NORM_L2);
  EXPECT_LT(four, 0.75 * one);
  EXPECT_LT(nine, 0.85 * four);
}

TEST(RenderOptions, EveryBadValueIsNamed) {
  EXPECT_EQ(RenderOptions().Check(), "");
  const auto complaint = [](auto change) {
    RenderOptions options;
    change(options);
    return options.Check();
  };
  EXPECT_NE(complaint([](auto& o) { o.samples_per_pixel = 5; }).find("samples_per_pixel"),
            std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.samples_per_pixel = 81; }), "");
  EXPECT_NE(complaint([](auto& o) { o.sun_elevation_deg = 0; }).find("sun_elevation_deg"),
            std::string::npos);
  EXPECT_NE(complaint([](auto& o) { o.sun_azimuth_deg = NAN; }), "");
  EXPECT_NE(complaint([](auto& o) { o.sun_strength = -1; }), "");
  EXPECT_NE(complaint([](auto& o) { o.sky_strength = 11; }), "");
  EXPECT_NE(complaint([](auto& o) { o.ambient_rays = -1; }), "");
  EXPECT_NE(complaint([](auto& o) { o.exposure = 0; }), "");
  EXPECT_NE(complaint([](auto& o) { o.sensor_noise_sigma = 51; }), "");
  EXPECT_NE(complaint([](auto& o) { o.shutter_s = 2; }), "");
}

TEST(Renderer, RefusesWhatItCannotRender) {
  RenderOptions bad;
  bad.exposure = 0;
  const TexturedScene good = GroundScene(FlatMaterial(1));
  EXPECT_THROW(Renderer(good, bad), UsageError);
  EXPECT_THROW(Renderer(TexturedScene(), RenderOptions()), Error);
  TexturedScene broken = good;
  broken.mesh.faces[1][2] = 99;
  EXPECT_THROW(Renderer(broken, RenderOptions()), Error);
  broken = good;
  broken.corner_uv.pop_back();
  EXPECT_THROW(Renderer(broken, RenderOptions()), Error);
  broken = good;
  broken.material_of_face[0] = 1;
  EXPECT_THROW(Renderer(broken, RenderOptions()), Error);
  broken = good;
  broken.mesh.vertices[0].x() = NAN;
  EXPECT_THROW(Renderer(broken, RenderOptions()), Error);
  const Renderer renderer(good, RenderOptions());
  EXPECT_THROW(renderer.Render({0, 10, 5, 5, 0, 0}, Rigid3d()), Error);
  EXPECT_THROW(renderer.RenderDepth({10, 10, 0, 5, 0, 0}, Rigid3d()), Error);
}

}  // namespace
}  // namespace colmap_ext
