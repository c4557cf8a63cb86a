#include "colmap_ext/scene/reconstruction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "scene/colmap_tool.h"
#include "scene/sparse_model.h"

namespace colmap_ext {
namespace {

TEST(CheckConsistency, AcceptsASoundModelAndAnEmptyOne) {
  EXPECT_NO_THROW(CheckConsistency(MakeSparseModel(), "model"));
  EXPECT_NO_THROW(CheckConsistency(Reconstruction(), "model"));
}

TEST(CheckConsistency, AcceptsPointsThatNobodySees) {
  // Models with known poses from other tools have such points.
  Reconstruction model = MakeSparseModel();
  model.points[1000].position = {1, 2, 3};
  EXPECT_NO_THROW(CheckConsistency(model, "model"));
}

struct Damage {
  const char* name;
  const char* message;
  std::function<void(Reconstruction*)> apply;
};

SparseImage& FirstImage(Reconstruction* model) { return model->images.begin()->second; }
Camera& FirstCamera(Reconstruction* model) { return model->cameras.begin()->second; }
SparsePoint& FirstPoint(Reconstruction* model) { return model->points.begin()->second; }
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Damage kDamages[] = {
    {"MissingCamera", "camera 1, which does not exist", [](auto* m) { m->cameras.erase(1); }},
    {"MissingPoint", "point 7, which does not exist", [](auto* m) { m->points.erase(7); }},
    {"MissingImage", "image 2, which does not exist", [](auto* m) { m->images.erase(2); }},
    {"TooManyParameters", "not the 3 of SIMPLE_PINHOLE",
     [](auto* m) { FirstCamera(m).params.push_back(0); }},
    {"TooFewParameters", "camera 1 has 2 parameters",
     [](auto* m) { FirstCamera(m).params.pop_back(); }},
    {"NanParameter", "not a finite number", [](auto* m) { FirstCamera(m).params[1] = kNan; }},
    {"ZeroFocalLength", "focal length", [](auto* m) { FirstCamera(m).params[0] = 0; }},
    {"NoSize", "no size", [](auto* m) { FirstCamera(m).height = 0; }},
    {"NanTranslation", "has a pose",
     [](auto* m) { FirstImage(m).cam_from_world.translation.y() = kNan; }},
    {"NanRotation", "has a pose",
     [](auto* m) { FirstImage(m).cam_from_world.rotation.coeffs().setConstant(kNan); }},
    {"ZeroRotation", "has a pose",
     [](auto* m) { FirstImage(m).cam_from_world.rotation.coeffs().setZero(); }},
    {"NoName", "no name", [](auto* m) { FirstImage(m).name.clear(); }},
    {"LineEndInName", "control character", [](auto* m) { FirstImage(m).name = "a\nb.jpg"; }},
    {"SameNameTwice", "two images have the name",
     [](auto* m) { FirstImage(m).name = m->images.rbegin()->second.name; }},
    {"NanKeypoint", "keypoint 1 at no finite place",
     [](auto* m) { FirstImage(m).keypoints[1].pixel.x() = kNan; }},
    {"KeypointOfNothing", "point 12345, which does not exist",
     [](auto* m) { FirstImage(m).keypoints[1].point3D_id = 12345; }},
    {"KeypointNotInTrack", "has a track of 3 elements, but 4 keypoints",
     [](auto* m) { FirstImage(m).keypoints[1].point3D_id = 7; }},
    {"TrackElementTwice", "has a track of 4 elements, but 3 keypoints",
     [](auto* m) { FirstPoint(m).track.push_back(FirstPoint(m).track[0]); }},
    {"TrackOfMissingKeypoint", "keypoint 4000000000 of image",
     [](auto* m) { FirstPoint(m).track[0].keypoint_index = 4000000000; }},
    {"TrackOfMissingImage", "image 999, which does not exist",
     [](auto* m) { FirstPoint(m).track[0].image_id = 999; }},
    {"TrackOfForeignKeypoint", "belongs to another point",
     [](auto* m) { FirstPoint(m).track[0].keypoint_index = 1; }},
    {"InfinitePoint", "not a finite number",
     [](auto* m) { FirstPoint(m).position.z() = kInfinity; }},
    {"NanError", "not a finite number", [](auto* m) { FirstPoint(m).error_px = kNan; }},
};

class DamagedModel : public testing::TestWithParam<Damage> {};
INSTANTIATE_TEST_SUITE_P(CheckConsistency, DamagedModel, testing::ValuesIn(kDamages),
                         [](const auto& info) { return info.param.name; });

TEST_P(DamagedModel, IsAnErrorThatNamesPlaceAndProblem) {
  Reconstruction model = MakeSparseModel();
  GetParam().apply(&model);
  const std::string message = ErrorOf([&] { CheckConsistency(model, "my/model"); });
  EXPECT_EQ(message.rfind("my/model: ", 0), 0u) << message;
  EXPECT_HAS(message, GetParam().message);
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(TransformReconstruction, MovesCentresAndPointsAndKeepsProjections) {
  const Reconstruction old_model = MakeSparseModel();
  Sim3d new_from_old;
  new_from_old.scale = 2.5;
  new_from_old.rotation = Eigen::Quaterniond(0.3, -0.4, 0.5, 0.6).normalized();
  new_from_old.translation = {10, -20, 30};
  Reconstruction model = old_model;
  TransformReconstruction(new_from_old, &model);
  for (const auto& [id, image] : model.images) {
    const SparseImage& old_image = old_model.images.at(id);
    const Eigen::Vector3d expected = new_from_old * CameraCenter(old_image.cam_from_world);
    EXPECT_LT((CameraCenter(image.cam_from_world) - expected).norm(), 1e-12);
  }
  for (const auto& [id, point] : model.points) {
    EXPECT_LT((point.position - new_from_old * old_model.points.at(id).position).norm(), 1e-12);
    for (const TrackElement& element : point.track) {
      const Eigen::Vector3d in_cam =
          model.images.at(element.image_id).cam_from_world * point.position;
      const Eigen::Vector3d old_in_cam =
          old_model.images.at(element.image_id).cam_from_world * old_model.points.at(id).position;
      EXPECT_LT((in_cam - 2.5 * old_in_cam).norm(), 1e-12);
    }
  }
  TransformReconstruction(Inverse(new_from_old), &model);
  for (const auto& [id, point] : model.points) {
    EXPECT_LT((point.position - old_model.points.at(id).position).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace colmap_ext
