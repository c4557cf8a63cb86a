#include "colmap_ext/mvs/superpixel_stereo.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/depth_map.h"
#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_io.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mvs/box_survey.h"

namespace colmap_ext {
namespace {

using test::Accuracy;
using test::AnalyticSurvey;
using test::BoxSurvey;
using test::ExpectSame;
using test::LookAt;
using test::Measure;
using test::TestCamera;

TEST(SuperpixelStereo, RebuildsABoxOnAFloor) {
  const AnalyticSurvey survey = BoxSurvey(600);
  const SuperpixelStereoResult result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  const Accuracy accuracy = Measure(result.views, survey.depth);
  EXPECT_GT(accuracy.confident_share, 0.6);
  EXPECT_LT(accuracy.median_error, 0.003);
  EXPECT_LT(accuracy.p90_error, 0.02);
  EXPECT_GT(result.superpixels.cpu_s + result.stereo.cpu_s + result.fusion.cpu_s, 0);
}

TEST(SuperpixelStereo, FusionImprovesWhatFewPointsGive) {
  AnalyticSurvey survey = BoxSurvey(400);
  // The middle photo is left with a tenth of its points.
  const int photo = 3;
  for (std::size_t p = 0; p < survey.photos.points.size(); ++p) {
    if (p % 10 != 0) std::erase(survey.photos.points[p].photo_indices, photo);
  }
  std::erase_if(survey.photos.points,
                [](const SupportPoint& point) { return point.photo_indices.size() < 2; });
  SuperpixelStereoOptions options;
  options.photometric = false;  // it gives the photo most of that by itself
  options.fusion_passes = 0;
  const auto measure = [&] {
    const auto result = RunSuperpixelStereo(survey.photos, {}, options, JobControl());
    return Measure({result.views[photo]}, {survey.depth[photo]});
  };
  const Accuracy before = measure();
  options.fusion_passes = 3;
  const Accuracy after = measure();
  EXPECT_GT(after.confident_share, before.confident_share + 0.05);
  EXPECT_LT(after.all_mean, 0.7 * before.all_mean);
}

TEST(SuperpixelStereo, ConfidencePredictsError) {
  const AnalyticSurvey survey = BoxSurvey(300);
  const auto result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  std::vector<double> sum(4), count(4);
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const ViewMaps maps = RasterizeView(result.views[i], 0);
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        if (maps.depth.At(y, x) <= 0 || !std::isfinite(survey.depth[i](y, x))) continue;
        const auto bin =
            std::min<std::size_t>(3, static_cast<std::size_t>(4 * maps.confidence.At(y, x)));
        sum[bin] += std::min(1.0, std::abs(maps.depth.At(y, x) / survey.depth[i](y, x) - 1));
        ++count[bin];
      }
    }
  }
  for (std::size_t bin = 1; bin < 4; ++bin) {
    ASSERT_GT(count[bin], 100);
    EXPECT_LT(sum[bin] / count[bin], sum[bin - 1] / count[bin - 1]) << bin;
  }
}

TEST(SuperpixelStereo, DoesNotDependOnTheNumberOfThreads) {
  const AnalyticSurvey survey = BoxSurvey(300, 4);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  };
  const auto one = run(1);
  for (const std::size_t threads : {2, 8}) {
    const auto many = run(threads);
    for (std::size_t i = 0; i < one.views.size(); ++i) {
      EXPECT_EQ(one.views[i].inverse_depth, many.views[i].inverse_depth);
      EXPECT_EQ(one.views[i].confidence, many.views[i].confidence);
      EXPECT_EQ(one.views[i].supported, many.views[i].supported);
    }
  }
}

TEST(SuperpixelStereo, FusionEndsWhenNothingMoves) {
  const AnalyticSurvey survey = BoxSurvey(300, 4);
  SuperpixelStereoOptions one_pass;
  one_pass.fusion_passes = 1;
  SuperpixelStereoOptions converged_at_once;
  converged_at_once.fusion_moving_share = 1.0;  // any share below 1 counts as converged
  ExpectSame(RunSuperpixelStereo(survey.photos, {}, one_pass, JobControl()),
             RunSuperpixelStereo(survey.photos, {}, converged_at_once, JobControl()));
}

TEST(SuperpixelStereo, APhotoWithoutPointsIsFilledByItsNeighbours) {
  AnalyticSurvey survey = BoxSurvey(500);
  SuperpixelStereoOptions options;
  SuperpixelStereoResult result = RunSuperpixelStereo(survey.photos, {}, options, JobControl());
  std::vector<ViewLookup> lookups;
  for (const ViewMesh& view : result.views) lookups.emplace_back(view, TriangleIdMap(view));
  PhotoSet bare = survey.photos;
  bare.points.clear();
  const LinearStereo solver(bare, 3, {}, result.views[3].image, lookups[3].triangle_at, options);
  result.views[3] = solver.initial();
  const std::vector<DepthRow> rows =
      CollectFusionRows(result.views, lookups, result.neighbors[3], 3, options);
  ASSERT_FALSE(rows.empty());
  ViewMesh filled = result.views[3];
  solver.Refine(std::vector<std::uint8_t>(filled.inverse_depth.size(), 0), rows, &filled);
  filled.confidence.assign(filled.confidence.size(), 1.0F);
  const Accuracy accuracy = Measure({filled}, {survey.depth[3]});
  EXPECT_GT(accuracy.confident_share, 0.7);
  EXPECT_LT(accuracy.median_error, 0.01);
}

TEST(SuperpixelStereo, DegenerateInputsGiveNoConfidence) {
  AnalyticSurvey survey = BoxSurvey(300, 3);
  PhotoSet no_points = survey.photos;
  no_points.points.clear();
  PhotoSet one_photo;
  one_photo.photos = {survey.photos.photos[0]};
  one_photo.points = survey.photos.points;
  for (SupportPoint& point : one_photo.points) point.photo_indices = {0};
  PhotoSet black = survey.photos;
  black.photos[0].bgr.setTo(0);
  for (const PhotoSet& photos : {no_points, one_photo, PhotoSet()}) {
    const auto result = RunSuperpixelStereo(photos, {}, {}, JobControl());
    EXPECT_EQ(result.views.size(), photos.photos.size());
    for (const ViewMesh& view : result.views) {
      for (const float confidence : view.confidence) EXPECT_EQ(confidence, 0.0F);
    }
    EXPECT_TRUE(SamplePoints(photos, result.views, result.neighbors, {}).empty());
  }
  for (const ViewMesh& view : RunSuperpixelStereo(black, {}, {}, JobControl()).views) {
    for (const Eigen::Vector3d& depth : view.inverse_depth) EXPECT_TRUE(depth.allFinite());
  }
}

TEST(SuperpixelStereo, BadInputIsRefused) {
  AnalyticSurvey survey = BoxSurvey(50, 2);
  SuperpixelStereoOptions options;
  options.num_neighbors = 0;
  EXPECT_THROW(RunSuperpixelStereo(survey.photos, {}, options, JobControl()), UsageError);
  survey.photos.photos[1].bgr = cv::Mat();
  EXPECT_THROW(RunSuperpixelStereo(survey.photos, {}, {}, JobControl()), Error);
  const std::atomic<bool> cancel = true;
  survey = BoxSurvey(50, 2);
  EXPECT_THROW(RunSuperpixelStereo(survey.photos, {}, {}, JobControl(nullptr, &cancel)),
               CancelledError);
}

TEST(Neighbors, AreChosenBySharedPointsAndAngle) {
  PhotoSet photos;
  for (const double x : {0.0, 0.02, 2.0, 30.0}) {  // too near for depth, good, too far apart
    PosedPhoto photo;
    photo.camera = TestCamera();
    photo.cam_from_world = LookAt({x, -10, 0}, {0, 0, 0});
    photos.photos.push_back(photo);
  }
  for (int i = 0; i < 20; ++i) {
    photos.points.push_back({{0.1 * i, 0, 0}, 0.3, {0, 1, 2, 3}});
  }
  const auto neighbors = FindNeighbors(photos, {});
  EXPECT_EQ(neighbors[0], (std::vector<int>{2, 1}));
  EXPECT_TRUE(std::find(neighbors[3].begin(), neighbors[3].end(), 0) == neighbors[3].end());
  SuperpixelStereoOptions options;
  options.num_neighbors = 1;
  EXPECT_EQ(FindNeighbors(photos, options)[0], std::vector<int>{2});
}

TEST(Points, LieOnTheSurfacesAndFaceTheCamera) {
  const AnalyticSurvey survey = BoxSurvey(600);
  const auto result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  const OrientedPoints points = SamplePoints(survey.photos, result.views, result.neighbors, {});
  ASSERT_GT(points.size(), 5000u);
  // Facets of sky along the ground's far edge (15 m) may follow that edge: of an edge before what
  // has no texture, photos cannot tell the side that it belongs to.
  constexpr double kGroundM = 14.0;
  std::vector<double> off;
  std::size_t wrong = 0;
  for (const OrientedPoint& point : points) {
    EXPECT_GT(point.confidence, 0.5F);
    EXPECT_NEAR(point.normal.norm(), 1, 1e-9);
    const auto& pose =
        survey.photos.photos[static_cast<std::size_t>(point.photo_index)].cam_from_world;
    EXPECT_GT(point.normal.dot(CameraCenter(pose) - point.position), 0);
    const Eigen::Vector3d& p = point.position;
    const double to_box = std::max(
        {std::abs(p.x()) - 1.5, std::abs(p.y()) - 1.5, p.z() - 2.5});  // signed, inside negative
    const double distance = std::min(std::abs(p.z()), std::abs(to_box));
    wrong += distance > 0.2;
    if (p.head<2>().lpNorm<Eigen::Infinity>() < kGroundM) off.push_back(distance);
  }
  ASSERT_GT(off.size(), 5000u);
  EXPECT_LT(static_cast<double>(wrong), 0.06 * static_cast<double>(points.size()));
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 0.03);
  EXPECT_LT(off[off.size() * 95 / 100], 0.06);
}

TEST(Points, ThatNeighboursSeeThroughAreDropped) {
  const AnalyticSurvey survey = BoxSurvey(600);
  auto result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  const std::size_t before = SamplePoints(survey.photos, result.views, result.neighbors, {}).size();
  // One view claims, with confidence, that everything is at two thirds of its distance.
  ViewMesh& liar = result.views[3];
  for (Eigen::Vector3d& depth : liar.inverse_depth) depth *= 1.5;
  liar.confidence.assign(liar.confidence.size(), 1.0F);
  liar.supported.assign(liar.supported.size(), 1);
  const OrientedPoints points = SamplePoints(survey.photos, result.views, result.neighbors, {});
  const auto lies = std::count_if(points.begin(), points.end(),
                                  [](const OrientedPoint& p) { return p.photo_index == 3; });
  EXPECT_LT(static_cast<double>(lies), 0.05 * static_cast<double>(before));
}

TEST(DepthMap, IsExactInsideTriangles) {
  const AnalyticSurvey survey = BoxSurvey(400, 3);
  const auto result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  const ViewMesh& view = result.views[1];
  const ViewMaps maps = RasterizeView(view, 0.5);
  const cv::Mat1i ids = TriangleIdMap(view);
  int filled = 0;
  for (int y = 0; y < 240; y += 7) {
    for (int x = 0; x < 320; x += 7) {
      const auto t = static_cast<std::size_t>(ids(y, x));
      EXPECT_EQ(maps.depth.At(y, x) > 0, view.supported[t] != 0 && view.confidence[t] >= 0.5);
      if (maps.depth.At(y, x) <= 0) continue;
      ++filled;
      // The point must lie in the plane of the triangle's corners in the world.
      const Eigen::Vector3d point = Inverse(view.cam_from_world) *
                                    (view.camera.Ray({x + 0.5, y + 0.5}) * maps.depth.At(y, x));
      const Eigen::Vector3d normal = TriangleNormalInWorld(view, static_cast<int>(t));
      EXPECT_NEAR(normal.dot(point - CornerInWorld(view, static_cast<int>(t), 0)), 0, 1e-4);
      const Eigen::Vector3d normal_in_cam(maps.normal.At(y, x, 0), maps.normal.At(y, x, 1),
                                          maps.normal.At(y, x, 2));
      EXPECT_NEAR((view.cam_from_world.rotation * normal - normal_in_cam).norm(), 0, 1e-4);
    }
  }
  EXPECT_GT(filled, 200);
}

TEST(StereoIo, DenseWorkspaceHoldsWhatColmapAsksFor) {
  const AnalyticSurvey survey = BoxSurvey(200, 2);
  const auto result = RunSuperpixelStereo(survey.photos, {}, {}, JobControl());
  Reconstruction model;
  model.cameras[1] = {CameraModel::kSimpleRadial, 320, 240, {300, 160, 120, 0.05}};
  for (const PosedPhoto& photo : survey.photos.photos) {
    model.images[photo.image_id] = {photo.name, 1, photo.cam_from_world, {{{200, 50}}}};
  }
  const auto folder = std::filesystem::path(testing::TempDir()) / "colmap_ext_stereo_io_test";
  std::filesystem::remove_all(folder);
  WriteDenseWorkspace(survey.photos, model, result.views, result.neighbors, 0, folder);
  WriteViewMeshes(survey.photos, result.views, 0.5, folder / "meshes");

  const DenseMap depth = ReadDenseMap(folder / "stereo/depth_maps" /
                                      (survey.photos.photos[0].name + ".geometric.bin"));
  EXPECT_EQ(depth.data, RasterizeView(result.views[0], 0).depth.data);
  const DenseMap normal = ReadDenseMap(folder / "stereo/normal_maps" /
                                       (survey.photos.photos[1].name + ".geometric.bin"));
  EXPECT_EQ(normal.channels, 3);
  EXPECT_EQ(ReadFile(folder / "stereo/fusion.cfg"), "photo_100.png\nphoto_101.png\n");
  EXPECT_EQ(ReadFile(folder / "stereo/patch-match.cfg"),
            "photo_100.png\nphoto_101.png\nphoto_101.png\nphoto_100.png\n");
  const Reconstruction read = ReadReconstruction(folder / "sparse");
  EXPECT_TRUE(IsPinhole(read.cameras.at(1)));
  const Eigen::Vector2d moved = read.images.begin()->second.keypoints[0].pixel;
  EXPECT_GT((moved - Eigen::Vector2d(200, 50)).norm(), 0.05);  // undistorted
  EXPECT_LT((moved - Eigen::Vector2d(200, 50)).norm(), 3.0);
  const ColoredMesh mesh = ReadColoredMesh(folder / "meshes/photo_100.png.ply");
  EXPECT_EQ(mesh.mesh.faces.size(), MeshInWorld(result.views[0], 0.5).mesh.faces.size());
  const Eigen::Vector3d center = CameraCenter(survey.photos.photos[0].cam_from_world);
  for (std::size_t f = 0; f < mesh.mesh.faces.size(); ++f) {
    const Eigen::Vector3d& corner =
        mesh.mesh.vertices[static_cast<std::size_t>(mesh.mesh.faces[f][0])];
    EXPECT_GT(FaceNormal(mesh.mesh, f).dot(center - corner), 0);
  }
  model.images.clear();
  EXPECT_THROW(WriteDenseWorkspace(survey.photos, model, result.views, result.neighbors, 0, folder),
               Error);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace colmap_ext
