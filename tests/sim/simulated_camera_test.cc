#include "colmap_ext/sim/simulated_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/sim/scene_views.h"
#include "colmap_ext/util/files.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::ErrorOf;
using test::ScratchFolder;

class SimulatedCameraTest : public ::testing::Test {
 protected:
  SimulatedCameraTest() {
    render_.sensor_noise_sigma = 1;
    camera_.width = 160;
    camera_.height = 92;
    camera_.focal_px = 120;
    camera_.full_width = 480;
    camera_.full_height = 270;
    scene_ = test::GroundScene(test::FlatMaterial(128));
    test::AddCube({-1, 3, 0}, 2, 0, 1, &scene_);
  }

  static PlannedView View(int id) {
    PlannedView view;
    view.id = id;
    view.position = {0.1 * id, -6, 4};
    view.direction = {DegToRad(3 * id), DegToRad(-25)};
    return view;
  }

  // Distance of the position in the photo from the true one.
  double GpsError(const std::filesystem::path& photo, int id) const {
    const auto metadata = ReadPhotoMetadata(photo);
    EXPECT_TRUE(metadata.gps.has_value());
    return (EnuFromGeo(scene_.origin, *metadata.gps) - View(id).position).norm();
  }

  TexturedScene scene_;
  RenderOptions render_;
  SimulatedCameraOptions camera_;
  ScratchFolder folder_{"camera"};
};

TEST_F(SimulatedCameraTest, PhotosDoNotDependOnOrder) {
  const Renderer renderer(scene_, render_);
  const SimulatedCamera camera(renderer, scene_.origin, camera_);
  for (const int id : {1, 2, 3}) camera.CapturePhoto(View(id), folder_ / std::to_string(id));
  const SimulatedCamera again(renderer, scene_.origin, camera_);
  for (const int id : {3, 1}) again.CapturePhoto(View(id), folder_ / ("b" + std::to_string(id)));
  EXPECT_EQ(ReadFile(folder_ / "1"), ReadFile(folder_ / "b1"));
  EXPECT_EQ(ReadFile(folder_ / "3"), ReadFile(folder_ / "b3"));
  EXPECT_NE(ReadFile(folder_ / "1"), ReadFile(folder_ / "2"));
}

TEST_F(SimulatedCameraTest, ExifHoldsWhatTheCameraKnows) {
  camera_.gps_noise_m = 0;
  const Renderer renderer(scene_, render_);
  const SimulatedCamera camera(renderer, scene_.origin, camera_);
  const CapturedPhoto photo = camera.CapturePhoto(View(5), folder_ / "a.jpg");
  EXPECT_LT(GpsError(folder_ / "a.jpg", 5), 2e-3);
  const PhotoMetadata metadata = ReadPhotoMetadata(folder_ / "a.jpg");
  EXPECT_EQ(metadata.width, 160);
  EXPECT_EQ(metadata.height, 92);
  ASSERT_TRUE(metadata.focal_px.has_value());
  EXPECT_NEAR(*metadata.focal_px, 120, 0.01);
  ASSERT_TRUE(metadata.yaw_rad.has_value());
  EXPECT_NEAR(*metadata.yaw_rad, DegToRad(15), 1e-3);
  EXPECT_LT((CameraCenter(photo.cam_from_world) - View(5).position).norm(), 1e-12);
  const ViewDirection direction = ViewDirectionOf(photo.cam_from_world);
  EXPECT_NEAR(direction.pitch_rad, DegToRad(-25), 1e-9);
}

TEST_F(SimulatedCameraTest, GpsNoiseHasItsSigma) {
  camera_.gps_noise_m = 0.5;
  const Renderer renderer(scene_, render_);
  const SimulatedCamera camera(renderer, scene_.origin, camera_);
  double sum = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  constexpr int kPhotos = 60;
  camera_.width = 16;
  for (int id = 0; id < kPhotos; ++id) {
    const CapturedPhoto photo = camera.CapturePhoto(View(id), folder_ / "n.jpg");
    const Eigen::Vector3d error = EnuFromGeo(scene_.origin, photo.gps) - View(id).position;
    sum += error.squaredNorm();
    mean += error / kPhotos;
  }
  EXPECT_NEAR(std::sqrt(sum / (3 * kPhotos)), 0.5, 0.1);
  EXPECT_LT(mean.norm(), 0.3);
}

TEST_F(SimulatedCameraTest, FullResolutionShowsTheSameAtTheSamePlace) {
  const Renderer renderer(scene_, render_);
  const SimulatedCamera camera(renderer, scene_.origin, camera_);
  const CapturedPhoto low = camera.CapturePhoto(View(4), folder_ / "low.jpg");
  const CapturedPhoto full =
      camera.CapturePhoto(View(4), folder_ / "full.jpg", PhotoResolution::kFull);
  EXPECT_EQ(full.camera.width, 480);
  EXPECT_EQ(full.camera.height, 270);
  EXPECT_EQ(cv::imread((folder_ / "full.jpg").string()).size(), cv::Size(480, 270));
  EXPECT_EQ(low.gps.lat_deg, full.gps.lat_deg);
  EXPECT_EQ(low.gps.height_m, full.gps.height_m);
  // A corner of the picture is the same direction in both.
  EXPECT_TRUE(low.camera.Ray({160, 92}).isApprox(full.camera.Ray({480, 270}), 1e-12));
}

TEST_F(SimulatedCameraTest, BadOptionsAndPlacesAreRefused) {
  const Renderer renderer(scene_, render_);
  const auto with = [&](auto change) {
    SimulatedCameraOptions options;
    change(options);
    return options.Check();
  };
  EXPECT_EQ(SimulatedCameraOptions().Check(), "");
  EXPECT_NE(with([](auto& o) { o.width = 0; }), "");
  EXPECT_NE(with([](auto& o) { o.full_height = 20000; }), "");
  EXPECT_NE(with([](auto& o) { o.focal_px = NAN; }).find("focal_px"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.gps_noise_m = -1; }).find("gps_noise_m"), std::string::npos);
  EXPECT_NE(with([](auto& o) { o.jpeg_quality = 101; }).find("jpeg_quality"), std::string::npos);
  SimulatedCameraOptions bad;
  bad.jpeg_quality = 0;
  EXPECT_THROW(SimulatedCamera(renderer, scene_.origin, bad), UsageError);
  WriteFileAtomically(folder_ / "file", "");
  const SimulatedCamera camera(renderer, scene_.origin, camera_);
  EXPECT_THROW(camera.CapturePhoto(View(1), folder_ / "file" / "a.jpg"), Error);
}

TEST(PoseList, IsReadInDegreesAndMetres) {
  const ScratchFolder folder("list");
  const auto path = folder / "poses.txt";
  WriteFileAtomically(path,
                      "# name x y z yaw pitch\nfirst 1 2 3 90 -30\nsub/second.png 4 5 6 0 0\n");
  const auto views = ReadPoseList(path);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0].name, "first.jpg");
  EXPECT_EQ(views[1].name, "sub/second.png");
  EXPECT_EQ(views[1].view.id, 1);
  EXPECT_EQ(views[0].view.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(DirectionInWorld(views[0].view.direction)
                  .isApprox(Eigen::Vector3d(std::sqrt(0.75), 0, -0.5), 1e-12));
}

TEST(PoseList, BadLinesAreNamed) {
  const ScratchFolder folder("badlist");
  const auto path = folder / "poses.txt";
  const auto message = [&](const std::string& content) {
    WriteFileAtomically(path, content);
    return ErrorOf([&] { ReadPoseList(path); });
  };
  EXPECT_NE(message("a 1 2 3 4\n").find("line 1"), std::string::npos);
  EXPECT_NE(message("a 1 2 3 4 5 6\n").find("line 1"), std::string::npos);
  EXPECT_NE(message("\na 1 2 x 4 5\n").find("line 2"), std::string::npos);
  EXPECT_NE(message("a 1 2 3 4 91\n").find("pitch"), std::string::npos);
  EXPECT_NE(message("../a 1 2 3 4 5\n").find("relative"), std::string::npos);
  EXPECT_NE(message("/a 1 2 3 4 5\n").find("relative"), std::string::npos);
  EXPECT_NE(message("a 1 2 3 4 5\na 1 2 3 4 5\n").find("twice"), std::string::npos);
  EXPECT_NE(message("# none\n").find("no view"), std::string::npos);
  EXPECT_NE(ErrorOf([&] { ReadPoseList(folder / "none"); }), "");
}

}  // namespace
}  // namespace colmap_ext
