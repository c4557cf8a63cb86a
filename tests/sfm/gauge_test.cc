#include "sfm/gauge.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

Reconstruction CamerasAt(const std::vector<Eigen::Vector3d>& centers) {
  Reconstruction model;
  ImageId id = 1;
  for (const Eigen::Vector3d& center : centers) {
    SparseImage image;
    image.cam_from_world = CamFromWorld(center, {0.3 * id, -0.4});
    model.images[id++] = image;
  }
  return model;
}

Sim3d SomeMove() {
  Sim3d move;
  move.scale = 0.37;
  move.rotation = Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized();
  move.translation = Eigen::Vector3d(4, -7, 2);
  return move;
}

TEST(ReferenceFromMoved, UndoesARigidMove) {
  const Reconstruction reference = CamerasAt({{0, 0, 0}, {5, 1, 2}, {-3, 8, 1}, {9, 9, 4}});
  Reconstruction moved = reference;
  TransformReconstruction(SomeMove(), &moved);
  moved.images[77] = moved.images.begin()->second;  // a new photo changes nothing
  TransformReconstruction(ReferenceFromMoved(reference, moved), &moved);
  for (const auto& [id, image] : reference.images) {
    const Rigid3d& back = moved.images.at(id).cam_from_world;
    EXPECT_LT((CameraCenter(back) - CameraCenter(image.cam_from_world)).norm(), 1e-12);
    EXPECT_LT(back.rotation.angularDistance(image.cam_from_world.rotation), 1e-12);
  }
}

TEST(ReferenceFromMoved, WorksForPhotosOnOneLine) {
  const Reconstruction reference = CamerasAt({{0, 0, 0}, {1, 2, 3}, {2, 4, 6}});
  Reconstruction moved = reference;
  TransformReconstruction(SomeMove(), &moved);
  TransformReconstruction(ReferenceFromMoved(reference, moved), &moved);
  const Rigid3d& back = moved.images.at(2).cam_from_world;
  EXPECT_LT(back.rotation.angularDistance(reference.images.at(2).cam_from_world.rotation), 1e-12);
  EXPECT_LT((CameraCenter(back) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
}

TEST(ReferenceFromMoved, RefusesModelsThatShareTooLittle) {
  const Reconstruction reference = CamerasAt({{0, 0, 0}, {1, 0, 0}});
  EXPECT_THROW(ReferenceFromMoved(reference, {}), Error);
  EXPECT_THROW(ReferenceFromMoved(reference, CamerasAt({{0, 0, 0}})), Error);
  EXPECT_THROW(ReferenceFromMoved(reference, CamerasAt({{1, 1, 1}, {1, 1, 1}})), Error);
}

}  // namespace
}  // namespace colmap_ext
