// What superpixel stereo keeps of photos when others come, and its file.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_memory_io.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mvs/box_survey.h"

namespace colmap_ext {
namespace {

using test::Accuracy;
using test::AnalyticSurvey;
using test::BoxSurvey;
using test::ExpectSame;
using test::Measure;

// Two neighbours each, so that a photo reaches only those beside it.
SuperpixelStereoOptions TwoNeighbors() {
  SuperpixelStereoOptions options;
  options.num_neighbors = 2;
  return options;
}

// The survey without the photos from `count` on, as it was before they were taken.
PhotoSet FirstPhotos(const PhotoSet& all, int count) {
  PhotoSet photos = all;
  photos.photos.resize(static_cast<std::size_t>(count));
  for (SupportPoint& point : photos.points) {
    std::erase_if(point.photo_indices, [&](int index) { return index >= count; });
  }
  std::erase_if(photos.points,
                [](const SupportPoint& point) { return point.photo_indices.size() < 2; });
  return photos;
}

void TakePixels(const std::vector<std::uint8_t>& needed, PhotoSet* photos) {
  for (std::size_t i = 0; i < needed.size(); ++i) {
    if (needed[i] == 0) photos->photos[i].bgr = cv::Mat();
  }
}

class StereoUpdateTest : public ::testing::Test {
 protected:
  // Updates with no more pixels than the plan asks for.
  SuperpixelStereoResult Update(PhotoSet photos) {
    update_ = PlanStereoUpdate(photos, {}, options_, memory_);
    TakePixels(update_.needs_pixels, &photos);
    return UpdateSuperpixelStereo(photos, {}, options_, update_, JobControl(), &memory_);
  }
  std::vector<int> Solved() const {
    std::vector<int> solved;
    for (std::size_t i = 0; i < update_.settled_scale.size(); ++i) {
      if (!update_.settled_scale[i]) solved.push_back(static_cast<int>(i));
    }
    return solved;
  }

  const AnalyticSurvey survey_ = BoxSurvey(400, 8);
  SuperpixelStereoOptions options_ = TwoNeighbors();
  StereoMemory memory_;
  StereoUpdate update_;
};

TEST_F(StereoUpdateTest, TheFirstOneIsARun) {
  ExpectSame(Update(survey_.photos),
             RunSuperpixelStereo(survey_.photos, {}, options_, JobControl()));
  EXPECT_EQ(Solved().size(), 8u);
}

TEST_F(StereoUpdateTest, KeepsEverythingWhenNothingChanged) {
  const SuperpixelStereoResult first = Update(survey_.photos);
  ExpectSame(Update(survey_.photos), first);
  EXPECT_TRUE(Solved().empty());
  EXPECT_EQ(std::ranges::count(update_.needs_pixels, 0), 8);
}

TEST_F(StereoUpdateTest, SolvesOnlyWhatANewPhotoReaches) {
  const SuperpixelStereoResult before = Update(FirstPhotos(survey_.photos, 7));
  const SuperpixelStereoResult after = Update(survey_.photos);
  const std::vector<int> solved = Solved();
  EXPECT_LE(solved.size(), 4u);
  EXPECT_EQ(solved.back(), 7);
  for (int i = 0; i < 7; ++i) {
    const std::vector<int>& around = after.neighbors[static_cast<std::size_t>(i)];
    EXPECT_EQ(std::ranges::count(solved, i), std::ranges::count(around, 7)) << i;
  }
  EXPECT_EQ(after.views[0].inverse_depth, before.views[0].inverse_depth);
  EXPECT_EQ(after.views[0].confidence, before.views[0].confidence);

  // As good as solving all.
  const Accuracy updated = Measure(after.views, survey_.depth);
  const Accuracy run =
      Measure(RunSuperpixelStereo(survey_.photos, {}, options_, JobControl()).views, survey_.depth);
  EXPECT_NEAR(updated.confident_share, run.confident_share, 0.03);
  EXPECT_LT(updated.median_error, 1.1 * run.median_error);
  EXPECT_LT(updated.p90_error, 1.1 * run.p90_error);
}

TEST_F(StereoUpdateTest, NoPhotoIsKeptWithoutTolerance) {
  options_.keep_tolerance_px = 0;
  Update(FirstPhotos(survey_.photos, 7));
  ExpectSame(Update(survey_.photos),
             RunSuperpixelStereo(survey_.photos, {}, options_, JobControl()));
  EXPECT_EQ(Solved().size(), 8u);
}

TEST_F(StereoUpdateTest, MeshesFollowTheWorld) {
  const SuperpixelStereoResult before = Update(survey_.photos);
  const Sim3d moved{
      1.004, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {5, -2, 1}};
  PhotoSet photos = survey_.photos;
  for (PosedPhoto& photo : photos.photos) {
    photo.cam_from_world = TransformCameraWorld(moved, photo.cam_from_world);
  }
  for (SupportPoint& point : photos.points) point.position = moved * point.position;
  const SuperpixelStereoResult after = Update(photos);
  EXPECT_TRUE(Solved().empty());
  for (std::size_t i = 0; i < after.views.size(); ++i) {
    for (std::size_t t = 0; t < after.views[i].supported.size(); ++t) {
      if (before.views[i].supported[t] == 0) continue;
      const Eigen::Vector3d was = CornerInWorld(before.views[i], static_cast<int>(t), 1);
      const Eigen::Vector3d is = CornerInWorld(after.views[i], static_cast<int>(t), 1);
      ASSERT_LT((is - moved * was).norm(), 1e-9 * (1 + was.norm()));
    }
  }
}

TEST_F(StereoUpdateTest, APhotoThatMovedIsSolvedAgainWithThoseBesideIt) {
  Update(survey_.photos);
  PhotoSet photos = survey_.photos;
  Rigid3d& pose = photos.photos[4].cam_from_world;
  const auto turned = [&](double px) {  // about the vertical of the photo
    const double angle = px / photos.photos[4].camera.fx;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
    return Rigid3d{turn, Eigen::Vector3d::Zero()} * survey_.photos.photos[4].cam_from_world;
  };
  pose = turned(0.15);
  EXPECT_TRUE(
      std::ranges::all_of(PlanStereoUpdate(photos, {}, options_, memory_).settled_scale,
                          [](const std::optional<double>& scale) { return scale.has_value(); }));
  pose = turned(0.5);
  Update(photos);
  for (int i = 0; i < 8; ++i) {
    const std::vector<int>& around = update_.neighbors[static_cast<std::size_t>(i)];
    EXPECT_EQ(std::ranges::count(Solved(), i) > 0, i == 4 || std::ranges::count(around, 4) > 0)
        << i;
  }
  // What was little by little is compared with when it was solved, not with the last time.
  pose = turned(0.15);
  EXPECT_FALSE(PlanStereoUpdate(photos, {}, options_, memory_).settled_scale[4].has_value());
}

TEST_F(StereoUpdateTest, AnAdjustedLensSolvesAgain) {
  PhotoSet photos = survey_.photos;
  const PinholeCamera& camera = photos.photos[0].camera;
  for (PosedPhoto& photo : photos.photos) {  // of twice the size
    photo.lens = {CameraModel::kSimpleRadial,
                  2 * camera.width,
                  2 * camera.height,
                  {2 * camera.fx, 2 * camera.cx, 2 * camera.cy, 0.01}};
  }
  Update(photos);
  photos.photos[1].lens.params.back() += 1e-4;  // hundredths of a pixel
  photos.photos[6].lens.params.back() += 0.1;
  update_ = PlanStereoUpdate(photos, {}, options_, memory_);
  EXPECT_EQ(Solved(), std::vector<int>{6});
}

TEST_F(StereoUpdateTest, MorePointsOtherOptionsAndLostNeighboursSolveAgain) {
  Update(survey_.photos);
  PhotoSet photos = survey_.photos;
  for (int k = 0; k < 300; ++k) {
    SupportPoint point = photos.points[static_cast<std::size_t>(k) % photos.points.size()];
    point.photo_indices = {2};
    photos.points.push_back(point);
  }
  update_ = PlanStereoUpdate(photos, {}, options_, memory_);
  EXPECT_EQ(Solved(), std::vector<int>{2});

  SuperpixelStereoOptions other = options_;
  other.smoothness_weight *= 2;
  update_ = PlanStereoUpdate(survey_.photos, {}, other, memory_);
  EXPECT_EQ(Solved().size(), 8u);

  update_ = PlanStereoUpdate(FirstPhotos(survey_.photos, 7), {}, options_, memory_);
  for (const int i : Solved()) EXPECT_GE(i, 5);
  EXPECT_FALSE(Solved().empty());
  other.keep_tolerance_px = -1;
  EXPECT_THROW(PlanStereoUpdate(survey_.photos, {}, other, memory_), UsageError);
}

TEST_F(StereoUpdateTest, PointsAreThoseOfARunAndStayWithTheirPhotos) {
  const SuperpixelStereoResult first = Update(survey_.photos);
  const OrientedPoints sampled = SamplePoints(survey_.photos, first.views, first.neighbors, {});
  PhotoSet no_pixels = survey_.photos;
  for (int pass = 0; pass < 2; ++pass) {  // the second time they are remembered, colours too
    const OrientedPoints points = UpdatePoints(pass == 0 ? survey_.photos : no_pixels, first.views,
                                               first.neighbors, {}, &memory_);
    ASSERT_EQ(points.size(), sampled.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      ASSERT_EQ(points[k].position, sampled[k].position);
      ASSERT_EQ(points[k].normal, sampled[k].normal);
      ASSERT_EQ(points[k].color, sampled[k].color);
      ASSERT_EQ(points[k].photo_index, sampled[k].photo_index);
    }
    for (PosedPhoto& photo : no_pixels.photos) photo.bgr = cv::Mat();
  }
  PointSamplerOptions denser;
  denser.step_px = 3;
  EXPECT_GT(UpdatePoints(survey_.photos, first.views, first.neighbors, denser, &memory_).size(),
            2 * sampled.size());
}

TEST_F(StereoUpdateTest, TheFileGivesTheSameToTheLastBit) {
  const SuperpixelStereoResult first = Update(FirstPhotos(survey_.photos, 7));
  UpdatePoints(FirstPhotos(survey_.photos, 7), first.views, first.neighbors, {}, &memory_);
  const auto file = std::filesystem::path(::testing::TempDir()) /
                    ("colmap_ext_stereo_" + std::to_string(getpid()) + ".bin");
  std::set<std::string> names;
  for (const auto& [name, settled] : memory_.photo) names.insert(name);
  WriteStereoMemory(memory_, names, file);
  StereoMemory read;
  ReadStereoMemory(file, &read);
  StereoMemory kept = memory_;
  const SuperpixelStereoResult here = Update(survey_.photos);
  memory_ = read;
  const SuperpixelStereoResult there = Update(survey_.photos);
  ExpectSame(here, there);
  EXPECT_LT(Solved().size(), 8u);
  const auto points_with = [&](StereoMemory* memory) {
    const StereoUpdate update = PlanStereoUpdate(survey_.photos, {}, options_, *memory);
    UpdateSuperpixelStereo(survey_.photos, {}, options_, update, JobControl(), memory);
    return UpdatePoints(survey_.photos, there.views, there.neighbors, {}, memory).size();
  };
  EXPECT_EQ(points_with(&kept), points_with(&read));

  // Photos that are there already stay as they are; a damaged file is named.
  memory_.photo.begin()->second.num_points = 12345;
  ReadStereoMemory(file, &memory_);
  EXPECT_EQ(memory_.photo.begin()->second.num_points, 12345u);
  const std::string bytes = ReadFile(file);
  for (const std::size_t length :
       {std::size_t{0}, std::size_t{20}, bytes.size() / 2, bytes.size() - 1}) {
    WriteFileAtomically(file, bytes.substr(0, length));
    StereoMemory memory;
    try {
      ReadStereoMemory(file, &memory);
      ADD_FAILURE() << length;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("remove it"), std::string::npos);
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace colmap_ext
