#include "colmap_ext/mvs/photometric.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/superpixels.h"
#include "mvs/analytic_scene.h"

namespace colmap_ext {
namespace {

using test::AnalyticScene;
using test::AnalyticSurvey;
using test::LookAt;

// A textured floor under five cameras, as meshes with exact depths.
class PhotometricStageTest : public ::testing::Test {
 protected:
  void SetUp() override { Build(60); }

  void Build(double contrast) {
    AnalyticScene scene;
    scene.rectangles.push_back(
        {{-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, {120, 140, 130}, 1, contrast});
    std::vector<Rigid3d> poses;
    for (int i = 0; i < 5; ++i) {
      poses.push_back(LookAt({1.2 * (i - 2), -6, 6 + 0.2 * (i % 2)}, {0, 0, 0}));
    }
    survey_ = test::Survey(scene, test::TestCamera(240, 160, 220), poses, 200);
    SuperpixelOptions superpixels;
    superpixels.target_polygons = 600;
    views_.clear();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const PosedPhoto& photo = survey_.photos.photos[i];
      ViewMesh view;
      view.photo_index = static_cast<int>(i);
      view.camera = photo.camera;
      view.cam_from_world = photo.cam_from_world;
      view.image = SegmentPhoto(photo.bgr, superpixels);
      view.supported.assign(view.image.triangles.size(), 1);
      view.confidence.assign(view.image.triangles.size(), 0.9F);
      for (const Eigen::Vector3i& corners : view.image.triangles) {
        Eigen::Vector3d inverse_depth;
        for (int k = 0; k < 3; ++k) {
          inverse_depth[k] =
              TrueInverseDepth(photo, view.image.vertices_px[static_cast<std::size_t>(corners[k])]);
        }
        view.inverse_depth.push_back(inverse_depth);
      }
      views_.push_back(view);
    }
    truth_ = views_;
    neighbors_ = FindNeighbors(survey_.photos, options_);
  }

  // On the plane z = 0.
  static double TrueInverseDepth(const PosedPhoto& photo, const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = photo.cam_from_world.rotation.conjugate() * photo.camera.Ray(pixel);
    return -ray.z() / CameraCenter(photo.cam_from_world).z();
  }

  std::vector<ViewLookup> Lookups() const {
    std::vector<ViewLookup> lookups;
    for (const ViewMesh& view : views_) lookups.emplace_back(view, TriangleIdMap(view));
    return lookups;
  }

  std::vector<DepthRow> Rows(int view) const {
    return PhotometricStage(survey_.photos, neighbors_, options_)
        .CollectRows(views_, Lookups(), view);
  }

  std::vector<PhotoCue> Cues(int view) const {
    std::vector<PhotoCue> cues;
    PhotometricStage(survey_.photos, neighbors_, options_)
        .EvaluateCues(views_, Lookups(), view, {}, &cues);
    return cues;
  }

  // Relative error at the centroid of the depth that a facet's three rows ask for.
  double ErrorOfRows(const DepthRow* rows, int view) const {
    Eigen::Matrix3d matrix;
    Eigen::Vector3d right_side;
    for (int r = 0; r < 3; ++r) {
      matrix.row(r) = rows[r].barycentric.transpose();
      right_side[r] = rows[r].inverse_depth;
    }
    const auto t = static_cast<std::size_t>(rows[0].triangle);
    const double asked = Eigen::Vector3d(matrix.inverse() * right_side).mean();
    return std::abs(asked / truth_[static_cast<std::size_t>(view)].inverse_depth[t].mean() - 1);
  }

  static double Median(std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }

  double MedianCorrelation(int view) const {
    std::vector<double> values;
    for (const PhotoCue& cue : Cues(view)) {
      if (cue.witnesses > 0) values.push_back(cue.correlation);
    }
    return Median(values);
  }

  AnalyticSurvey survey_;
  SuperpixelStereoOptions options_;
  std::vector<ViewMesh> views_, truth_;
  std::vector<std::vector<int>> neighbors_;
};

TEST_F(PhotometricStageTest, TruePlanesCorrelateAndWrongOnesDoNot) {
  EXPECT_GT(MedianCorrelation(2), 0.85);
  for (Eigen::Vector3d& corners : views_[2].inverse_depth) corners *= 1.15;
  EXPECT_LT(MedianCorrelation(2), 0.6);
}

TEST_F(PhotometricStageTest, RowsLeadToTheTruth) {
  for (Eigen::Vector3d& corners : views_[2].inverse_depth) corners *= 1.01;
  const std::vector<DepthRow> rows = Rows(2);
  ASSERT_GT(rows.size(), views_[2].image.triangles.size());  // three a facet, of a third of them
  ASSERT_EQ(rows.size() % 3, 0U);
  std::vector<double> errors;
  for (std::size_t r = 0; r < rows.size(); r += 3) {
    EXPECT_EQ(rows[r].triangle, rows[r + 2].triangle);
    EXPECT_GT(rows[r].weight, 0);
    errors.push_back(ErrorOfRows(&rows[r], 2));
  }
  EXPECT_LT(Median(errors), 0.002);
}

TEST_F(PhotometricStageTest, WrongFacetsTakeThePlaneOfOthers) {
  std::mt19937 random(5);
  std::vector<std::uint8_t> spoiled(views_[2].image.triangles.size(), 0);
  double num_spoiled = 0;
  for (std::size_t t = 0; t < spoiled.size(); ++t) {
    if (random() % 6 != 0) continue;
    spoiled[t] = 1;
    ++num_spoiled;
    views_[2].inverse_depth[t] *= random() % 2 == 0 ? 0.7 : 1.4;
    views_[2].confidence[t] = 0.1F;
  }
  const std::vector<DepthRow> rows = Rows(2);
  double mended = 0, wrong = 0;
  for (std::size_t r = 0; r < rows.size(); r += 3) {
    if (spoiled[static_cast<std::size_t>(rows[r].triangle)] == 0) continue;
    (ErrorOfRows(&rows[r], 2) < 0.02 ? mended : wrong) += 1;
  }
  EXPECT_GT(mended, 0.6 * num_spoiled);
  EXPECT_LT(wrong, 0.15 * num_spoiled);
}

TEST_F(PhotometricStageTest, FlatPhotosSayNothing) {
  Build(0);
  EXPECT_TRUE(Rows(2).empty());
  for (const PhotoCue& cue : Cues(2)) EXPECT_EQ(PhotoConsistency(cue, options_), 1.0);
}

TEST_F(PhotometricStageTest, ViewsWithoutNeighborsHaveNoWitness) {
  neighbors_[2].clear();
  EXPECT_TRUE(Rows(2).empty());
  for (const PhotoCue& cue : Cues(2)) {
    EXPECT_EQ(cue.witnesses, 0);
    EXPECT_EQ(PhotoConsistency(cue, options_), 1.0);
  }
}

TEST(PhotoConsistency, FallsWithTheCorrelation) {
  const SuperpixelStereoOptions options;
  double last = 2;
  for (const float correlation : {1.0F, 0.8F, 0.5F, 0.0F, -0.5F}) {
    const double factor = PhotoConsistency({3, correlation, 20.0F}, options);
    EXPECT_GT(factor, 0);
    EXPECT_LE(factor, 1);
    EXPECT_LT(factor, last);
    last = factor;
  }
}

}  // namespace
}  // namespace colmap_ext
