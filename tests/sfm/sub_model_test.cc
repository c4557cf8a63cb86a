#include "sfm/sub_model.h"

#include <gtest/gtest.h>

#include <random>

#include "sfm/update_database.h"

namespace colmap_ext {
namespace {

constexpr int kPhotos = 30, kPoints = 300, kSeenBy = 6;

// Photos on a line; point p is seen by photos p/10 … p/10 + 5, each photo's keypoint k is the k-th
// point that it sees, followed by some that see nothing.
Reconstruction LongModel() {
  Reconstruction model;
  model.cameras[1] = {CameraModel::kSimplePinhole, 640, 480, {500, 320, 240}};
  for (ImageId i = 1; i <= kPhotos; ++i) {
    SparseImage image;
    image.name = "photo" + std::to_string(i);
    image.camera_id = 1;
    image.cam_from_world = CamFromWorld({2.0 * i, 0, 0}, {0, 0});
    model.images[i] = image;
  }
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> side(-3, 3);
  for (Point3DId p = 1; p <= kPoints; ++p) {
    const ImageId first = 1 + static_cast<ImageId>(p) * (kPhotos - kSeenBy) / kPoints;
    SparsePoint& point = model.points[p];
    point.position = {2.0 * first + 5 + side(generator), 30, side(generator)};
    point.error_px = 0.5;
    for (ImageId i = first; i < first + kSeenBy; ++i) {
      SparseImage& image = model.images.at(i);
      const Eigen::Vector3d in_cam = image.cam_from_world * point.position;
      point.track.push_back({i, static_cast<std::uint32_t>(image.keypoints.size())});
      image.keypoints.push_back({{320 + 500 * in_cam.x() / in_cam.z(), 240}, p});
    }
  }
  for (auto& [id, image] : model.images) image.keypoints.resize(image.keypoints.size() + 5);
  return model;
}

std::set<ImageId> Range(ImageId first, ImageId last) {
  std::set<ImageId> ids;
  for (ImageId i = first; i <= last; ++i) ids.insert(i);
  return ids;
}

void ExpectSame(const Reconstruction& a, const Reconstruction& b) {
  ASSERT_EQ(a.images.size(), b.images.size());
  ASSERT_EQ(a.points.size(), b.points.size());
  for (const auto& [id, point] : a.points) {
    EXPECT_EQ(point.position, b.points.at(id).position);
    EXPECT_EQ(point.error_px, b.points.at(id).error_px);
    EXPECT_EQ(point.track.size(), b.points.at(id).track.size());
  }
  for (const auto& [id, image] : a.images) {
    EXPECT_EQ(image.cam_from_world.translation, b.images.at(id).cam_from_world.translation);
    for (std::size_t k = 0; k < image.keypoints.size(); ++k) {
      EXPECT_EQ(image.keypoints[k].point3D_id, b.images.at(id).keypoints[k].point3D_id);
    }
  }
}

TEST(SubModel, KeepsIdsAndThePointsThatTwoOfItsPhotosSee) {
  const Reconstruction model = LongModel();
  const Reconstruction part = SubModel(model, Range(10, 14));
  CheckConsistency(part, "part");
  EXPECT_EQ(part.images.size(), 5u);
  EXPECT_GT(part.points.size(), 40u);
  for (const auto& [id, point] : part.points) {
    EXPECT_GE(point.track.size(), 2u);
    EXPECT_EQ(point.position, model.points.at(id).position);
  }
  std::size_t seen_by_two = 0;
  for (const auto& [id, point] : model.points) {
    int inside = 0;
    for (const TrackElement& element : point.track) {
      inside += element.image_id >= 10 && element.image_id <= 14;
    }
    seen_by_two += inside >= 2;
  }
  EXPECT_EQ(part.points.size(), seen_by_two);
}

TEST(MergeSubModel, ChangesNothingWhereNothingChanged) {
  const Reconstruction model = LongModel();
  const Reconstruction part = SubModel(model, Range(8, 16));
  Reconstruction merged = model;
  const MergedPart result = MergeSubModel(part, part, &merged);
  EXPECT_TRUE(result.new_images.empty());
  EXPECT_TRUE(result.changed_points.empty());
  CheckConsistency(merged, "merged");
  ExpectSame(model, merged);
}

// A new photo that sees the point `seen`, a new point beside, and one that the part was too small
// to hold.
struct Continued {
  Reconstruction model = LongModel(), before, after;
  Point3DId seen = 0, weak = 0;
  Continued() {
    before = SubModel(model, Range(8, 16));
    after = before;
    SparseImage& image = after.images[99];
    image.name = "new";
    image.camera_id = 1;
    image.keypoints.resize(4);
    seen = after.points.begin()->first;
    for (const auto& [id, point] : model.points) {
      const bool known = before.points.count(id) > 0;
      if (!known && point.track.back().image_id == 8) weak = id;
    }
    Extend(seen, {99, 0});
    SparsePoint fresh;
    fresh.position = {1, 2, 3};
    const auto unused = static_cast<std::uint32_t>(after.images.at(9).keypoints.size() - 1);
    AddPoint(500, fresh, {{99, 1}, {9, unused}});
    SparsePoint twin;
    twin.position = {4, 5, 6};
    AddPoint(501, twin, {{99, 2}, model.points.at(weak).track.back()});
  }
  void Extend(Point3DId id, TrackElement element) {
    after.points.at(id).track.push_back(element);
    after.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id = id;
  }
  void AddPoint(Point3DId id, SparsePoint point, std::vector<TrackElement> track) {
    after.points[id] = std::move(point);
    for (const TrackElement& element : track) Extend(id, element);
  }
};

TEST(MergeSubModel, AddsPhotosAndPointsAndKeepsWhatTheRestSees) {
  Continued c;
  ASSERT_NE(c.weak, 0u);
  Reconstruction merged = c.model;
  const MergedPart result = MergeSubModel(c.before, c.after, &merged);
  CheckConsistency(merged, "merged");
  EXPECT_EQ(result.new_images, std::set<ImageId>{99});
  EXPECT_EQ(result.changed_points.size(), 3u);
  EXPECT_EQ(merged.points.size(), c.model.points.size() + 1);
  // Extended: every old observation and the new one.
  EXPECT_EQ(merged.points.at(c.seen).track.size(), kSeenBy + 1u);
  // Seen by one photo of the part: the new observation joins the old point, not a twin of it.
  EXPECT_EQ(merged.points.at(c.weak).track.size(), kSeenBy + 1u);
  EXPECT_EQ(merged.points.at(c.weak).position, c.model.points.at(c.weak).position);
  EXPECT_EQ(merged.images.at(99).keypoints[2].point3D_id, c.weak);
  // New: under an id that the whole model has not.
  EXPECT_EQ(c.model.points.count(merged.images.at(99).keypoints[1].point3D_id), 0u);
  EXPECT_EQ(merged.images.at(99).keypoints[3].point3D_id, kInvalidPoint3DId);
}

TEST(MergeSubModel, DropsWhatWasDroppedAndJoinsWhatWasJoined) {
  const Reconstruction model = LongModel();
  const Reconstruction before = SubModel(model, Range(8, 16));
  Reconstruction after = before;
  // Two points become one, as COLMAP does it: a new id with both tracks.
  auto a = after.points.begin();
  auto b = std::next(a);
  const Point3DId first = a->first, second = b->first;
  SparsePoint joined = a->second;
  joined.track.insert(joined.track.end(), b->second.track.begin(), b->second.track.end());
  after.points.erase(first);
  after.points.erase(second);
  for (const TrackElement& element : joined.track) {
    after.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id = 700;
  }
  after.points[700] = joined;
  // A third loses an observation.
  SparsePoint& shorter = after.points.rbegin()->first == 700
                             ? std::prev(after.points.end(), 2)->second
                             : after.points.rbegin()->second;
  const TrackElement dropped = shorter.track.back();
  shorter.track.pop_back();
  after.images.at(dropped.image_id).keypoints[dropped.keypoint_index].point3D_id =
      kInvalidPoint3DId;
  Reconstruction merged = model;
  const MergedPart result = MergeSubModel(before, after, &merged);
  CheckConsistency(merged, "merged");
  EXPECT_EQ(result.changed_points.size(), 2u);
  EXPECT_EQ(merged.points.size(), model.points.size() - 1);
  EXPECT_EQ(merged.points.count(first), 1u);
  EXPECT_EQ(merged.points.count(second), 0u);
  EXPECT_EQ(merged.images.at(dropped.image_id).keypoints[dropped.keypoint_index].point3D_id,
            kInvalidPoint3DId);
}

TEST(MergeSubModel, APointThatThePartLostLivesOnWhereOthersSeeIt) {
  const Reconstruction model = LongModel();
  const Reconstruction before = SubModel(model, Range(8, 16));
  Reconstruction after = before;
  Point3DId shared = 0, own = 0;  // with four photos outside the part; with none
  for (const auto& [id, point] : before.points) {
    if (point.track.size() == 2 && shared == 0) shared = id;
    if (point.track.size() == kSeenBy && own == 0) own = id;
  }
  for (const Point3DId id : {shared, own}) {
    for (const TrackElement& element : after.points.at(id).track) {
      after.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id =
          kInvalidPoint3DId;
    }
    after.points.erase(id);
  }
  Reconstruction merged = model;
  MergeSubModel(before, after, &merged);
  CheckConsistency(merged, "merged");
  EXPECT_EQ(merged.points.count(shared), 1u);
  EXPECT_EQ(merged.points.count(own), 0u);
}

TwoViewSummary Inliers(std::size_t count) { return {TwoViewConfig::kCalibrated, count}; }

TEST(ChooseScope, TakesThePhotosThatNewOnesMatchAMarginAndFailedOnesBesideThem) {
  const Reconstruction model = LongModel();
  std::map<ImagePair, TwoViewSummary> pairs;
  for (ImageId i = 1; i < kPhotos; ++i) pairs[{i, i + 1}] = Inliers(100);
  pairs[{10, 50}] = Inliers(40);               // new
  pairs[{50, 51}] = Inliers(30);               // failed earlier, seen by the new one
  pairs[{20, 52}] = Inliers(kMinInliers - 1);  // new, but hardly matched
  pairs[{28, 53}] = Inliers(90);               // failed earlier, elsewhere
  const UpdateScope scope = ChooseScope(model, pairs, {50, 52});
  EXPECT_EQ(scope.missing, (std::set<ImageId>{50, 51}));
  EXPECT_EQ(scope.registered.count(10), 1u);
  EXPECT_EQ(scope.registered.count(28), 0u);
  EXPECT_GT(scope.registered.size(), 1u);
  EXPECT_LE(scope.registered.size(), 13u);
}

TEST(ChooseScope, IsEmptyForPhotosThatMatchNothing) {
  const UpdateScope scope = ChooseScope(LongModel(), {}, {77});
  EXPECT_TRUE(scope.missing.empty());
  EXPECT_TRUE(scope.registered.empty());
}

}  // namespace
}  // namespace colmap_ext
