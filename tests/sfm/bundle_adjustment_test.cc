#include "colmap_ext/sfm/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <atomic>

#include "colmap_ext/util/error.h"
#include "sfm/gauge.h"
#include "sfm/synthetic_model.h"

namespace colmap_ext {
namespace {

// Tight, so that tests may ask for the truth itself.
BundleOptions Tight() {
  BundleOptions options;
  options.function_tolerance = 1e-14;
  options.max_iterations = 100;
  return options;
}

BundleSelection WithPositions(const Reconstruction& truth, double sigma_m, unsigned seed) {
  std::mt19937_64 random(seed);
  BundleSelection selection;
  for (const auto& [id, image] : truth.images) {
    PhotoPrior prior;
    prior.position_in_world = CameraCenter(image.cam_from_world) + Gaussian3(&random, sigma_m);
    prior.sigma_horizontal_m = prior.sigma_vertical_m = std::max(0.01, sigma_m);
    selection.prior_of_image[id] = prior;
  }
  return selection;
}

bool SamePose(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

TEST(AdjustBundle, FindsTheTruthFromDisturbedPosesAndPoints) {
  const Reconstruction truth = RingModel(12, 150);
  Reconstruction model = truth;
  PerturbPoses(0.2, 0.01, 1, &model);
  PerturbPoints(0.2, 2, &model);
  const BundleResult result = AdjustBundle({}, Tight(), {}, &model);
  EXPECT_GT(result.initial_rms_px, 3);
  EXPECT_LT(result.final_rms_px, 1e-6);
  EXPECT_EQ(model.points.size(), truth.points.size());
  const Sim3d truth_from_model = TruthFromModel(truth, model);
  EXPECT_LT(LargestCenterError(truth, model, truth_from_model), 1e-6);
  for (const auto& [id, point] : model.points) {
    EXPECT_LT((truth_from_model * point.position - truth.points.at(id).position).norm(), 1e-5);
    EXPECT_LT(point.error_px, 1e-5);
    EXPECT_GE(point.error_px, 0);
  }
}

TEST(AdjustBundle, DoesNotMoveTheModelAsAWholeWithoutPriors) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.3;
  Reconstruction model = RingModel(10, 120, how);
  PerturbPoses(0.3, 0.01, 1, &model);
  const Reconstruction before = model;
  AdjustBundle({}, Tight(), {}, &model);
  EXPECT_GT(LargestCenterError(before, model), 0.05);
  const Sim3d move = ReferenceFromMoved(before, model);
  EXPECT_NEAR(move.scale, 1, 1e-9);
  EXPECT_LT(move.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
  EXPECT_LT((move * Eigen::Vector3d::Zero()).norm(), 1e-7);
}

TEST(AdjustBundle, MovesFreePhotosOnlyAndThoseToTheTruth) {
  const Reconstruction truth = RingModel(12, 150);
  Reconstruction model = truth;
  PerturbPoses(0.2, 0.01, 1, &model);
  BundleSelection selection;
  selection.free_images = {3, 4, 7};
  for (const auto& [id, image] : truth.images) {
    if (selection.free_images->count(id) == 0) model.images[id] = image;
  }
  const BundleResult result = AdjustBundle(selection, Tight(), {}, &model);
  EXPECT_EQ(result.num_free_images, 3);
  for (const auto& [id, image] : truth.images) {
    const Rigid3d& pose = model.images.at(id).cam_from_world;
    if (selection.free_images->count(id) == 0) {
      EXPECT_TRUE(SamePose(pose, image.cam_from_world)) << id;
    } else {
      EXPECT_LT((CameraCenter(pose) - CameraCenter(image.cam_from_world)).norm(), 1e-6) << id;
    }
  }
}

TEST(AdjustBundle, LeavesPointsThatAreNotFree) {
  const Reconstruction truth = RingModel(8, 80);
  Reconstruction model = truth;
  PerturbPoses(0.1, 0.005, 1, &model);
  BundleSelection selection;
  selection.free_images = {2};
  selection.free_points = std::set<Point3DId>{};  // resection of one photo
  const BundleResult result = AdjustBundle(selection, Tight(), {}, &model);
  EXPECT_EQ(result.num_free_points, 0);
  EXPECT_LT((CameraCenter(model.images.at(2).cam_from_world) -
             CameraCenter(truth.images.at(2).cam_from_world))
                .norm(),
            1e-6);
  for (const auto& [id, point] : truth.points) {
    EXPECT_EQ(model.points.at(id).position, point.position);
  }
}

TEST(AdjustBundle, CostsWhatItTouches) {
  Reconstruction model = ChainModel(60, 1500);
  BundleSelection selection;
  selection.free_images = {30};
  const BundleResult one = AdjustBundle(selection, {}, {}, &model);
  EXPECT_LT(one.num_free_points, 400);
  EXPECT_EQ(one.num_free_points,
            static_cast<int>(std::count_if(
                model.images.at(30).keypoints.begin(), model.images.at(30).keypoints.end(),
                [](const auto& k) { return k.point3D_id != kInvalidPoint3DId; })));
}

TEST(AdjustBundle, TakesScaleAndPlaceFromPositions) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.3;
  const Reconstruction truth = RingModel(40, 300, how);
  Reconstruction model = truth;
  Sim3d move;
  move.scale = 1.1;
  move.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized());
  move.translation = Eigen::Vector3d(2, -3, 1);
  TransformReconstruction(move, &model);
  const BundleResult result = AdjustBundle(WithPositions(truth, 1.5, 5), Tight(), {}, &model);
  EXPECT_NEAR(TruthFromModel(truth, model).scale, 1, 0.01);
  EXPECT_LT(LargestCenterError(truth, model), 1.0);
  EXPECT_NEAR(result.prior_rms_m, 1.5 * std::sqrt(3), 0.4);
  EXPECT_TRUE(result.disagreements.empty());
}

// A row of photos, bent and stretched little by little; `amount`: 1 for a row of 150 m.
Reconstruction Drifted(const Reconstruction& truth, double amount = 1) {
  Reconstruction model = truth;
  const auto bend = [amount](const Eigen::Vector3d& point) {
    const double x = point.x(), bent = amount * x * x;
    return Eigen::Vector3d((1 + 0.03 * amount) * x, point.y() + 4e-4 * bent,
                           point.z() + 6e-4 * bent);
  };
  for (auto& [id, image] : model.images) {
    const Eigen::Vector3d center = bend(CameraCenter(image.cam_from_world));
    image.cam_from_world.translation = -(image.cam_from_world.rotation * center);
  }
  for (auto& [id, point] : model.points) point.position = bend(point.position);
  return model;
}

TEST(AdjustBundle, PullsADriftedChainStraight) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.3;
  const Reconstruction truth = ChainModel(50, 1500, how);
  Reconstruction model = Drifted(truth);
  EXPECT_GT(LargestCenterError(truth, model), 10);
  AdjustBundle(WithPositions(truth, 0.5, 3), Tight(), {}, &model);
  EXPECT_LT(LargestCenterError(truth, model), 0.6);
  EXPECT_NEAR(TruthFromModel(truth, model).scale, 1, 0.01);
}

// More photos than equations are factorised for.
TEST(AdjustBundle, PullsAChainOfHundredsStraight) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.3;
  const Reconstruction truth = ChainModel(450, 13500, how);
  Reconstruction model = Drifted(truth, 1.0 / 81);
  EXPECT_GT(LargestCenterError(truth, model), 10);
  BundleOptions options;
  options.max_iterations = 100;
  AdjustBundle(WithPositions(truth, 0.5, 3), options, {}, &model);
  EXPECT_LT(LargestCenterError(truth, model), 0.6);
  EXPECT_NEAR(TruthFromModel(truth, model).scale, 1, 0.01);
}

TEST(AdjustBundle, FindsTheTruthOfHundredsOfPhotosAroundOnePlace) {
  const Reconstruction truth = RingModel(410, 400);
  Reconstruction model = truth;
  PerturbPoses(0.1, 0.005, 1, &model);
  PerturbPoints(0.1, 2, &model);
  const BundleResult result = AdjustBundle({}, Tight(), {}, &model);
  EXPECT_LT(result.final_rms_px, 1e-3);
  EXPECT_LT(LargestCenterError(truth, model, TruthFromModel(truth, model)), 1e-3);
}

TEST(AdjustBundle, IsNotBentByOneWildPosition) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.3;
  const Reconstruction truth = RingModel(30, 250, how);
  BundleSelection selection = WithPositions(truth, 0.3, 5);
  Reconstruction model = truth;
  PerturbPoses(0.1, 0.002, 9, &model);
  Reconstruction undisturbed = model;
  AdjustBundle(selection, Tight(), {}, &undisturbed);
  *selection.prior_of_image[7].position_in_world += Eigen::Vector3d(60, -30, 10);
  const BundleResult result = AdjustBundle(selection, Tight(), {}, &model);
  EXPECT_LT(LargestCenterError(undisturbed, model), 0.03);
  ASSERT_EQ(result.disagreements.size(), 1U);
  EXPECT_EQ(result.disagreements[0].image_id, 7U);
  EXPECT_NEAR(result.disagreements[0].residual_m, 67.8, 1.5);
}

TEST(AdjustBundle, TakesTheVerticalFromAttitudesWherePositionsAreOnOneLine) {
  const Reconstruction truth = ChainModel(12, 400);
  BundleSelection selection = WithPositions(truth, 0, 1);
  for (auto& [id, prior] : selection.prior_of_image) {
    prior.up_in_cam = truth.images.at(id).cam_from_world.rotation * Eigen::Vector3d::UnitZ();
  }
  Reconstruction model = truth;
  Sim3d roll;  // about the line of flight
  roll.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  roll.translation = Eigen::Vector3d(0, 0, 20) - roll.rotation * Eigen::Vector3d(0, 0, 20);
  TransformReconstruction(roll, &model);
  AdjustBundle(selection, Tight(), {}, &model);
  EXPECT_LT(LargestCenterError(truth, model), 1e-3);
  for (const auto& [id, image] : truth.images) {
    EXPECT_LT(
        image.cam_from_world.rotation.angularDistance(model.images.at(id).cam_from_world.rotation),
        1e-4);
  }
}

TEST(AdjustBundle, EstimatesIntrinsicsOfASharedCamera) {
  SyntheticModel how;
  how.camera = {CameraModel::kSimpleRadial, 640, 368, {480, 320, 184, -0.08}};
  const Reconstruction truth = RingModel(16, 250, how);
  Reconstruction model = truth;
  model.cameras[1].params = {500, 320, 184, 0};
  BundleOptions options = Tight();
  options.refine_focal_length = options.refine_extra_params = true;
  const BundleResult result = AdjustBundle({}, options, {}, &model);
  EXPECT_TRUE(result.refused_cameras.empty());
  EXPECT_NEAR(model.cameras.at(1).params[0], 480, 1e-3);
  EXPECT_NEAR(model.cameras.at(1).params[3], -0.08, 1e-5);
  EXPECT_EQ(model.cameras.at(1).params[1], 320);
}

TEST(AdjustBundle, RefusesAbsurdIntrinsicsAndKeepsTheGivenOnes) {
  Reconstruction model = RingModel(8, 80);
  // Keypoints without any relation to the points: distortion may become anything.
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> x(0, 640), y(0, 368);
  for (auto& [id, image] : model.images) {
    for (Keypoint2D& keypoint : image.keypoints) keypoint.pixel = {x(random), y(random)};
  }
  model.cameras[1] = {CameraModel::kRadial, 640, 368, {480, 320, 184, 0.001, -0.002}};
  BundleOptions options;
  options.refine_focal_length = options.refine_extra_params = true;
  options.loss_scale_px = 0;
  const BundleResult result = AdjustBundle({}, options, {}, &model);
  EXPECT_EQ(result.refused_cameras, std::vector<CameraId>{1});
  EXPECT_EQ(model.cameras.at(1).params, (std::vector<double>{480, 320, 184, 0.001, -0.002}));
}

TEST(AdjustBundle, RefusesADegenerateCamera) {
  const Reconstruction good = RingModel(5, 30);
  for (const double focal : {0.0, -480.0, std::nan("")}) {
    Reconstruction model = good;
    model.cameras[1].params[1] = focal;
    EXPECT_THROW(AdjustBundle({}, {}, {}, &model), Error) << focal;
  }
  Reconstruction model = good;
  model.cameras[1].params.pop_back();
  EXPECT_THROW(AdjustBundle({}, {}, {}, &model), Error);
}

TEST(AdjustBundle, DropsWildObservations) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.2;
  const Reconstruction truth = RingModel(12, 150, how);
  Reconstruction model = truth;
  model.images.at(3).keypoints[5].pixel += Eigen::Vector2d(40, -25);
  const Point3DId disturbed = model.images.at(3).keypoints[5].point3D_id;
  const BundleResult result = AdjustBundle({}, {}, {}, &model);
  EXPECT_EQ(result.num_filtered_observations, 1U);
  EXPECT_EQ(result.num_filtered_points, 0U);
  EXPECT_EQ(model.images.at(3).keypoints[5].point3D_id, kInvalidPoint3DId);
  EXPECT_EQ(model.points.at(disturbed).track.size() + 1, truth.points.at(disturbed).track.size());
  EXPECT_NO_THROW(CheckConsistency(model, "model"));
  EXPECT_LT(LargestCenterError(truth, model, TruthFromModel(truth, model)), 0.03);
}

TEST(AdjustBundle, DropsPointsWithoutAngleOrBehindTheCamera) {
  Reconstruction model = RingModel(6, 60);
  const Point3DId far = model.points.rbegin()->first + 1;
  for (const ImageId id : {1U, 2U}) {  // one direction, from places a few centimetres apart
    const Rigid3d& pose = model.images.at(1).cam_from_world;
    SparseImage& image = model.images.at(id);
    if (id == 2)
      image.cam_from_world = {pose.rotation, pose.translation + Eigen::Vector3d(.05, 0, 0)};
    const Eigen::Vector3d point = Inverse(pose) * Eigen::Vector3d(1, 1, 400);
    model.points[far].position = point;
    model.points[far].track.push_back({id, static_cast<std::uint32_t>(image.keypoints.size())});
    image.keypoints.push_back(
        {ImageFromNormalized(model.cameras[1], (image.cam_from_world * point).hnormalized()), far});
  }
  model.points.begin()->second.position = Eigen::Vector3d(0, 0, 900);  // above all cameras
  const Point3DId behind = model.points.begin()->first;
  BundleSelection selection;
  selection.free_images = std::set<ImageId>{};
  selection.free_points = {far, behind};
  const BundleResult result = AdjustBundle(selection, {}, {}, &model);
  EXPECT_EQ(result.num_filtered_points, 2U);
  EXPECT_EQ(model.points.count(far) + model.points.count(behind), 0U);
  EXPECT_NO_THROW(CheckConsistency(model, "model"));
}

TEST(AdjustBundle, GivesTheSameBitsEveryTime) {
  SyntheticModel how;
  how.keypoint_noise_px = 0.5;
  Reconstruction first = RingModel(12, 150, how);
  PerturbPoses(0.1, 0.005, 1, &first);
  Reconstruction second = first;
  const BundleSelection selection = WithPositions(first, 0.5, 3);
  AdjustBundle(selection, {}, {}, &first);
  AdjustBundle(selection, {}, {}, &second);
  for (const auto& [id, image] : first.images) {
    EXPECT_TRUE(SamePose(image.cam_from_world, second.images.at(id).cam_from_world));
  }
  for (const auto& [id, point] : first.points) {
    EXPECT_EQ(point.position, second.points.at(id).position);
  }
}

TEST(AdjustBundle, LeavesTheModelWhenCancelled) {
  Reconstruction model = RingModel(6, 60);
  PerturbPoses(0.1, 0.005, 1, &model);
  const Reconstruction before = model;
  const std::atomic<bool> cancel{true};
  EXPECT_THROW(AdjustBundle({}, {}, JobControl(nullptr, &cancel), &model), CancelledError);
  for (const auto& [id, image] : before.images) {
    EXPECT_TRUE(SamePose(image.cam_from_world, model.images.at(id).cam_from_world));
  }
}

TEST(AdjustBundle, NamesWhatIsWrong) {
  Reconstruction model = RingModel(4, 30);
  BundleSelection unknown_photo, unknown_point, bad_prior, bad_sigma;
  unknown_photo.free_images = {99};
  EXPECT_THROW(AdjustBundle(unknown_photo, {}, {}, &model), Error);
  unknown_point.free_points = {12345};
  EXPECT_THROW(AdjustBundle(unknown_point, {}, {}, &model), Error);
  bad_prior.prior_of_image[1].position_in_world = Eigen::Vector3d(0, std::nan(""), 0);
  EXPECT_THROW(AdjustBundle(bad_prior, {}, {}, &model), Error);
  bad_sigma.prior_of_image[1] = {Eigen::Vector3d::Zero(), 0, 1, {}, 1};
  EXPECT_THROW(AdjustBundle(bad_sigma, {}, {}, &model), Error);
  BundleOptions options;
  options.filter_min_angle_deg = 90;
  EXPECT_THROW(AdjustBundle({}, options, {}, &model), UsageError);
}

TEST(AdjustBundle, DoesNothingToAnEmptyModel) {
  Reconstruction model;
  const BundleResult result = AdjustBundle({}, {}, {}, &model);
  EXPECT_EQ(result.num_observations, 0U);
  EXPECT_TRUE(model.images.empty());
}

}  // namespace
}  // namespace colmap_ext
