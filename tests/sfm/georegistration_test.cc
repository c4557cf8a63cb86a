#include "colmap_ext/sfm/georegistration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

Sim3d TrueWorldFromModel() {
  Sim3d truth;
  truth.scale = 7.3;
  truth.rotation = Eigen::Quaterniond(0.3, -0.7, 0.5, 0.2).normalized();
  truth.translation = Eigen::Vector3d(120, -45, 33);
  return truth;
}

// A level camera at a place in the world, as the model (in its own frame) holds it.
MeasuredCamera CameraAt(const Eigen::Vector3d& position, double yaw_rad, double pitch_rad, int i) {
  const Rigid3d cam_from_world = CamFromWorld(position, {yaw_rad, pitch_rad});
  return {"photo" + std::to_string(i) + ".jpg",
          TransformCameraWorld(Inverse(TrueWorldFromModel()), cam_from_world), position};
}

// Level cameras around a house of 30 x 20 m, looking inwards, 30 degrees down.
std::vector<MeasuredCamera> RectangleFlight(int count) {
  std::vector<MeasuredCamera> cameras;
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * 3.14159265358979 * i / count;
    const Eigen::Vector3d position(15 * std::sin(turn), 10 * std::cos(turn), 20 + (i % 2));
    cameras.push_back(CameraAt(position, turn + 3.14159265358979, -0.52, i));
  }
  return cameras;
}

std::vector<MeasuredCamera> StraightFlight(int count, double yaw_rad, double pitch_rad) {
  std::vector<MeasuredCamera> cameras;
  for (int i = 0; i < count; ++i) {
    cameras.push_back(CameraAt(Eigen::Vector3d(4.0 * i, 1.0 * i, 25), yaw_rad, pitch_rad, i));
  }
  return cameras;
}

void AddNoise(std::vector<MeasuredCamera>* cameras, double sigma_m, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0, sigma_m);
  for (MeasuredCamera& camera : *cameras) {
    for (int k = 0; k < 3; ++k) camera.position_in_world[k] += noise(generator);
  }
}

double AngleDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return RadToDeg(a.angularDistance(b));
}

void ExpectTruth(const Sim3d& found, double tolerance) {
  const Sim3d truth = TrueWorldFromModel();
  EXPECT_NEAR(found.scale / truth.scale, 1, tolerance);
  EXPECT_LT(DegToRad(AngleDeg(found.rotation, truth.rotation)), 10 * tolerance);
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-1, 2, 3)}) {
    EXPECT_LT((found * point - truth * point).norm(), 200 * tolerance);
  }
}

TEST(Georegister, RecoversExactInputToRounding) {
  const GeoregistrationResult result = Georegister(RectangleFlight(20), {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  ExpectTruth(*result.world_from_model, 1e-10);
  EXPECT_LT(result.rms_m, 1e-9);
  EXPECT_EQ(result.num_used, 20);
  EXPECT_TRUE(result.outliers.empty());
  EXPECT_FALSE(result.gravity_from_cameras);
}

TEST(Georegister, NamesGrossOutliersAndIsNotMovedByThem) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(40);
  for (const std::size_t i : {3u, 17u, 30u, 31u}) {
    cameras[i].position_in_world += Eigen::Vector3d(40 + static_cast<double>(i), -25, 60);
  }
  const GeoregistrationResult result = Georegister(cameras, {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  ExpectTruth(*result.world_from_model, 1e-10);
  ASSERT_EQ(result.outliers.size(), 4u);
  EXPECT_EQ(result.outliers[0].name, "photo31.jpg");  // the worst first
  EXPECT_NEAR(result.outliers[0].residual_m, Eigen::Vector3d(71, -25, 60).norm(), 1e-6);
}

TEST(Georegister, HoldsTheScaleUnderGpsNoiseAndOutliers) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::vector<MeasuredCamera> cameras = RectangleFlight(64);
    AddNoise(&cameras, 1.5, seed);
    for (std::size_t i = 0; i < 64; i += 11) cameras[i].position_in_world.z() += 50;
    const GeoregistrationResult result = Georegister(cameras, {});
    ASSERT_TRUE(result.world_from_model) << result.refusal;
    EXPECT_NEAR(result.world_from_model->scale / TrueWorldFromModel().scale, 1, 0.04);
    EXPECT_LT(AngleDeg(result.world_from_model->rotation, TrueWorldFromModel().rotation), 4);
    EXPECT_EQ(result.outliers.size(), 6u);
    EXPECT_NEAR(result.rms_m, 1.5 * std::sqrt(3.0), 0.6);
  }
}

TEST(Georegister, TakesGravityFromLevelCamerasOnOneStraightLine) {
  const GeoregistrationResult result = Georegister(StraightFlight(12, 1.3, -1.2), {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  EXPECT_TRUE(result.gravity_from_cameras);
  ExpectTruth(*result.world_from_model, 1e-8);
}

TEST(Georegister, TakesGravityFromLevelCamerasOnANoisyLine) {
  std::vector<MeasuredCamera> cameras = StraightFlight(20, 1.3, -0.6);
  AddNoise(&cameras, 1.0, 3);
  cameras[5].position_in_world.y() += 70;
  const GeoregistrationResult result = Georegister(cameras, {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  EXPECT_TRUE(result.gravity_from_cameras);
  const Eigen::Vector3d up = result.world_from_model->rotation *
                             (TrueWorldFromModel().rotation.conjugate() * Eigen::Vector3d::UnitZ());
  EXPECT_LT(RadToDeg(std::acos(up.z())), 3);
  ASSERT_EQ(result.outliers.size(), 1u);
  EXPECT_EQ(result.outliers[0].name, "photo5.jpg");
}

TEST(Georegister, RefusesALineOfCamerasThatAllLookAcrossIt) {
  const double along = std::atan2(4.0, 1.0);  // heading of the flight
  const GeoregistrationResult result =
      Georegister(StraightFlight(12, along + 1.5707963267948966, -0.5), {});
  EXPECT_FALSE(result.world_from_model);
  EXPECT_NE(result.refusal.find("one line"), std::string::npos) << result.refusal;
}

TEST(Georegister, RefusesTooFewPhotosPositionsInOnePlaceAndNonsense) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(10);
  EXPECT_NE(Georegister({cameras[0], cameras[1]}, {}).refusal, "");
  std::vector<MeasuredCamera> hovering = cameras;
  for (MeasuredCamera& camera : hovering) camera.position_in_world = Eigen::Vector3d(1, 2, 3);
  EXPECT_FALSE(Georegister(hovering, {}).world_from_model);
  AddNoise(&hovering, 2.0, 1);
  EXPECT_FALSE(Georegister(hovering, {}).world_from_model);
  AddNoise(&cameras, 500, 2);
  const GeoregistrationResult result = Georegister(cameras, {});
  EXPECT_FALSE(result.world_from_model);
  EXPECT_NE(result.refusal.find("agree"), std::string::npos) << result.refusal;
}

TEST(Georegister, GivesTheSameTwice) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(30);
  AddNoise(&cameras, 2.0, 9);
  const GeoregistrationResult a = Georegister(cameras, {}), b = Georegister(cameras, {});
  EXPECT_EQ(a.world_from_model->scale, b.world_from_model->scale);
  EXPECT_EQ(a.world_from_model->translation, b.world_from_model->translation);
}

TEST(GeoregistrationOptions, NamesWhatIsWrong) {
  GeoregistrationOptions options;
  EXPECT_EQ(options.Check(), "");
  options.max_residual_m = -1;
  EXPECT_THROW(Georegister({}, options), UsageError);
  options = {};
  options.ransac_samples = 0;
  EXPECT_NE(options.Check().find("ransac_samples"), std::string::npos);
}

// Gives every camera its true vertical.
void AddAttitudes(std::vector<MeasuredCamera>* cameras) {
  for (MeasuredCamera& camera : *cameras) {
    const Rigid3d cam_from_world =
        TransformCameraWorld(TrueWorldFromModel(), camera.cam_from_model);
    camera.up_in_cam = cam_from_world.rotation * Eigen::Vector3d::UnitZ();
  }
}

// Turns each camera about its own axis, so that it is level no more.
void AddRoll(double roll_rad, std::vector<MeasuredCamera>* cameras) {
  for (MeasuredCamera& camera : *cameras) {
    const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
    camera.cam_from_model.rotation = roll * camera.cam_from_model.rotation;
    camera.cam_from_model.translation = roll * camera.cam_from_model.translation;
  }
}

TEST(Georegister, TakesTheVerticalOfRolledCamerasFromTheirAttitudes) {
  std::vector<MeasuredCamera> cameras = StraightFlight(12, 0.3, -0.9);
  AddRoll(0.4, &cameras);
  AddAttitudes(&cameras);
  const GeoregistrationResult result = Georegister(cameras, {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  ExpectTruth(*result.world_from_model, 1e-6);
  EXPECT_EQ(result.num_attitudes, 12);
  EXPECT_TRUE(result.gravity_from_cameras);
}

// Cameras that look along a straight flight tell nothing about its roll unless it was measured.
TEST(Georegister, AttitudesTellWhatLevelCamerasCannot) {
  std::vector<MeasuredCamera> cameras = StraightFlight(12, 0, -1.57);
  for (MeasuredCamera& camera : cameras) camera.sigma_vertical_m = 3;
  AddRoll(0.2, &cameras);
  AddAttitudes(&cameras);
  AddNoise(&cameras, 0.3, 4);
  const GeoregistrationResult result = Georegister(cameras, {});
  ASSERT_TRUE(result.world_from_model) << result.refusal;
  EXPECT_LT(AngleDeg(result.world_from_model->rotation, TrueWorldFromModel().rotation), 2);
}

TEST(Georegister, AttitudesHoldTheTiltAgainstNoisyPositions) {
  double sum_without_deg = 0, sum_with_deg = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<MeasuredCamera> cameras = RectangleFlight(8);
    AddNoise(&cameras, 1.5, seed);
    const auto tilt_deg = [&cameras] {
      const GeoregistrationResult result = Georegister(cameras, {});
      const Eigen::Quaterniond error =
          result.world_from_model->rotation * TrueWorldFromModel().rotation.conjugate();
      return RadToDeg(std::acos(std::min(1.0, (error * Eigen::Vector3d::UnitZ()).z())));
    };
    sum_without_deg += tilt_deg();
    AddAttitudes(&cameras);
    sum_with_deg += tilt_deg();
  }
  EXPECT_LT(sum_with_deg, 0.5 * sum_without_deg);
}

TEST(Georegister, AccuratePositionsCountMore) {
  std::vector<MeasuredCamera> exact = RectangleFlight(24), noisy = exact;
  AddNoise(&noisy, 2, 11);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (i % 3 != 0) exact[i].position_in_world = noisy[i].position_in_world;
  }
  const GeoregistrationResult alike = Georegister(exact, {});
  for (std::size_t i = 0; i < exact.size(); i += 3) {
    exact[i].sigma_horizontal_m = exact[i].sigma_vertical_m = 0.02;
  }
  const GeoregistrationResult weighted = Georegister(exact, {});
  ASSERT_TRUE(alike.world_from_model && weighted.world_from_model);
  const double true_scale = TrueWorldFromModel().scale;
  EXPECT_GT(std::abs(alike.world_from_model->scale / true_scale - 1), 1e-3);
  EXPECT_LT(std::abs(weighted.world_from_model->scale / true_scale - 1), 2e-4);
}

// Consumer GPS errs by more than loss_scale_m: the loss must not throw most of it away.
TEST(Georegister, NoisyPositionsGiveTheScaleAlmostAsWellAsLeastSquares) {
  GeoregistrationOptions least_squares;
  least_squares.loss_scale_m = 1e4;
  double robust_sum = 0, least_sum = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::vector<MeasuredCamera> cameras = RectangleFlight(40);
    AddNoise(&cameras, 1.5, seed);
    const auto error_of = [&](const GeoregistrationOptions& options) {
      const GeoregistrationResult result = Georegister(cameras, options);
      return result.world_from_model.value().scale / TrueWorldFromModel().scale - 1;
    };
    robust_sum += std::pow(error_of({}), 2);
    least_sum += std::pow(error_of(least_squares), 2);
  }
  RecordProperty("rms_of_least_squares", std::to_string(std::sqrt(robust_sum / least_sum)));
  EXPECT_LT(std::sqrt(robust_sum / least_sum), 1.03);
}

TEST(Georegister, RefusesImpossibleAccuracies) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(5);
  cameras[2].sigma_vertical_m = 0;
  EXPECT_THROW(Georegister(cameras, {}), Error);
  cameras[2].sigma_vertical_m = 1;
  cameras[2].up_in_cam = Eigen::Vector3d(0, 0, 2);
  EXPECT_THROW(Georegister(cameras, {}), Error);
}

TEST(GeoregistrationReport, NamesWhatDisagreesInMetres) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(10);
  cameras[4].position_in_world += Eigen::Vector3d(30, 40, -12);
  const GeoregistrationResult result = Georegister(cameras, {});
  const Json report = Json::parse(GeoregistrationReport(result));
  EXPECT_TRUE(report["georegistered"].get<bool>());
  EXPECT_NEAR(report["scale"].get<double>(), TrueWorldFromModel().scale, 1e-6);
  EXPECT_EQ(report["disagreeing"], Json::array({"photo4.jpg"}));
  ASSERT_EQ(report["photos"].size(), 10U);
  EXPECT_NEAR(report["photos"][4]["horizontal_m"].get<double>(), 50, 1e-6);
  EXPECT_NEAR(report["photos"][4]["vertical_m"].get<double>(), 12, 1e-6);
  EXPECT_FALSE(report["photos"][4]["agrees"].get<bool>());
  EXPECT_LT(report["rms_m"].get<double>(), 1e-6);
  const Json refusal = Json::parse(GeoregistrationReport(Georegister({cameras[0]}, {})));
  EXPECT_FALSE(refusal["georegistered"].get<bool>());
  EXPECT_NE(refusal["refusal"].get<std::string>(), "");
}

TEST(ComparePositions, MeasuresAModelThatIsInTheWorld) {
  std::vector<MeasuredCamera> cameras = RectangleFlight(6);
  for (MeasuredCamera& camera : cameras) {
    camera.cam_from_model = TransformCameraWorld(TrueWorldFromModel(), camera.cam_from_model);
    camera.position_in_world += Eigen::Vector3d(3, 4, 0);
  }
  const GeoregistrationResult result = ComparePositions(cameras, {});
  EXPECT_NEAR(result.rms_m, 5, 1e-9);
  EXPECT_EQ(result.num_used, 6);
  EXPECT_EQ(result.world_from_model->scale, 1);
}

}  // namespace
}  // namespace colmap_ext
