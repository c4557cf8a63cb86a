#include "session/arbitrary_frame.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Two level cameras 0.5 apart that look at points 2 in front of them, in a world that lies on its
// side.
Reconstruction TiltedModel() {
  Reconstruction model;
  model.cameras[1] = ToCamera(PinholeCamera{640, 480, 500, 500, 320, 240});
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()));
  for (ImageId id = 1; id <= 2; ++id) {
    SparseImage image;
    image.name = std::to_string(id);
    image.camera_id = 1;
    image.cam_from_world = CamFromWorld({0.5 * id, 0, 0}, {0.0, 0.0});
    image.cam_from_world =
        TransformCameraWorld(Sim3d{0.1, tilt, Eigen::Vector3d(5, 5, 5)}, image.cam_from_world);
    for (Point3DId point = 1; point <= 5; ++point) {
      image.keypoints.push_back({Eigen::Vector2d(10, 10), point});
    }
    model.images[id] = image;
  }
  const Sim3d tilted_from_level{0.1, tilt, Eigen::Vector3d(5, 5, 5)};
  for (Point3DId id = 1; id <= 5; ++id) {
    SparsePoint point;
    point.position = tilted_from_level * Eigen::Vector3d(0.75, 2.0, 0.1 * static_cast<double>(id));
    for (ImageId image = 1; image <= 2; ++image) {
      point.track.push_back({image, static_cast<std::uint32_t>(id - 1)});
    }
    model.points[id] = point;
  }
  return model;
}

TEST(NormalizeArbitraryFrame, MakesTheWorldUprightAndOfTheWantedSize) {
  Reconstruction model = TiltedModel();
  NormalizeArbitraryFrame(30.0, &model);
  for (const auto& [id, image] : model.images) {
    EXPECT_NEAR(ViewDirectionOf(image.cam_from_world).pitch_rad, 0.0, 1e-9);
    const Eigen::Vector3d up =
        image.cam_from_world.rotation.conjugate() * Eigen::Vector3d(0, -1, 0);
    EXPECT_NEAR(up.z(), 1.0, 1e-9);
  }
  const double distance =
      (model.points[3].position - CameraCenter(model.images[1].cam_from_world)).norm();
  EXPECT_NEAR(distance, 30.0, 0.5);
}

TEST(NormalizeArbitraryFrame, RefusesAModelWithoutPoints) {
  Reconstruction model = TiltedModel();
  for (auto& [id, image] : model.images) image.keypoints.clear();
  model.points.clear();
  EXPECT_THROW(NormalizeArbitraryFrame(30.0, &model), Error);
}

TEST(TypicalViewingDistance, LeavesAMarginToTheWantedResolution) {
  CoverageOptions options;
  options.ground_sampling_distance_mm = 60;
  EXPECT_NEAR(TypicalViewingDistance(options, TiltedModel()), 500 * 0.06 / 1.5, 1e-9);
}

}  // namespace
}  // namespace colmap_ext
