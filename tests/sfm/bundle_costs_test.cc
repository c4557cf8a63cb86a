#include "sfm/bundle_costs.h"

#include <gtest/gtest.h>

#include <functional>

#include "sfm/synthetic_model.h"

namespace colmap_ext {
namespace {

std::vector<Camera> CamerasOfEveryModel() {
  return {
      {CameraModel::kSimplePinhole, 640, 368, {500, 318, 186}},
      {CameraModel::kPinhole, 640, 368, {500, 510, 318, 186}},
      {CameraModel::kSimpleRadial, 640, 368, {500, 318, 186, -0.15}},
      {CameraModel::kRadial, 640, 368, {500, 318, 186, -0.2, 0.05}},
      {CameraModel::kOpenCV, 640, 368, {500, 510, 318, 186, -0.25, 0.08, 0.002, -0.003}},
      {CameraModel::kOpenCVFisheye, 640, 368, {300, 305, 318, 186, 0.05, -0.02, 0.004, -0.001}},
      {CameraModel::kFullOpenCV,
       640,
       368,
       {500, 510, 318, 186, 0.3, -0.1, 0.001, 0.002, 0.02, 0.5, -0.05, 0.01}},
      {CameraModel::kFOV, 640, 368, {400, 405, 318, 186, 0.9}},
      {CameraModel::kSimpleRadialFisheye, 640, 368, {300, 318, 186, 0.03}},
      {CameraModel::kRadialFisheye, 640, 368, {300, 318, 186, 0.03, -0.01}},
      {CameraModel::kThinPrismFisheye,
       640,
       368,
       {300, 305, 318, 186, 0.03, -0.01, 0.001, -0.002, 0.003, -0.001, 0.0015, -0.0005}},
  };
}

BundleOptions AllFree() {
  BundleOptions options;
  options.refine_focal_length = options.refine_principal_point = options.refine_extra_params = true;
  return options;
}

// Compares the derivative of `cost` by each entry of `block` with differences of its residuals.
void ExpectDerivatives(const ceres::CostFunction& cost, const std::vector<double*>& blocks,
                       BundleState* state) {
  const int num_residuals = cost.num_residuals();
  const auto residuals_now = [&] {
    RefreshState(state).PrepareForEvaluation(true, true);
    Eigen::VectorXd residuals(num_residuals);
    EXPECT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), nullptr));
    return residuals;
  };
  RefreshState(state).PrepareForEvaluation(true, true);
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (const int size : cost.parameter_block_sizes()) {
    storage.emplace_back(static_cast<std::size_t>(num_residuals * size));
  }
  for (std::vector<double>& jacobian : storage) jacobians.push_back(jacobian.data());
  Eigen::VectorXd residuals(num_residuals);
  ASSERT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), jacobians.data()));
  constexpr double kStep = 1e-6;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const int size = cost.parameter_block_sizes()[b];
    for (int k = 0; k < size; ++k) {
      const double value = blocks[b][k];
      blocks[b][k] = value + kStep;
      const Eigen::VectorXd more = residuals_now();
      blocks[b][k] = value - kStep;
      const Eigen::VectorXd less = residuals_now();
      blocks[b][k] = value;
      for (int r = 0; r < num_residuals; ++r) {
        const double numeric = (more[r] - less[r]) / (2 * kStep);
        const double analytic = storage[b][static_cast<std::size_t>(r * size + k)];
        EXPECT_NEAR(analytic, numeric, 1e-4 * (1 + std::abs(numeric)))
            << "block " << b << ", parameter " << k << ", residual " << r;
      }
    }
  }
}

class ReprojectionCostOf : public testing::TestWithParam<Camera> {};
INSTANTIATE_TEST_SUITE_P(Models, ReprojectionCostOf, testing::ValuesIn(CamerasOfEveryModel()),
                         [](const auto& info) {
                           return std::string(
                               GetCameraModelInfo(static_cast<int>(info.param.model)).name);
                         });

TEST_P(ReprojectionCostOf, HasTheDerivativesOfItsResiduals) {
  SyntheticModel how;
  how.camera = GetParam();
  const Reconstruction model = RingModel(4, 5, how);
  const BundleSelection selection;
  BundleState state = GatherBundle(selection, AllFree(), {}, model);
  BundlePose& pose = state.poses[1];
  for (const double turn : {0.0, 0.3}) {
    std::fill_n(pose.turn_and_center, 3, turn);
    const auto seen = std::find_if(state.observations.begin(), state.observations.end(),
                                   [](const BundleObservation& o) { return o.pose == 1; });
    ASSERT_NE(seen, state.observations.end());
    BundleObservation observation = *seen;
    const ReprojectionCost cost(state, observation, 0.7);
    ExpectDerivatives(cost,
                      {pose.turn_and_center, state.points[observation.point].position.data(),
                       state.cameras[0].free_values},
                      &state);
  }
}

TEST(ReprojectionCost, HasBlocksForWhatIsFreeOnly) {
  const Reconstruction model = RingModel(4, 20);
  BundleSelection selection;
  selection.free_images = {1, 2};
  const BundleState state = GatherBundle(selection, {}, {}, model);
  for (const BundleObservation& observation : state.observations) {
    const ReprojectionCost cost(state, observation, 1);
    const std::vector<int> wanted =
        state.poses[observation.pose].is_free ? std::vector<int>{6, 3} : std::vector<int>{3};
    EXPECT_EQ(cost.parameter_block_sizes(), wanted);
  }
}

TEST(PriorCosts, HaveTheDerivativesOfTheirResiduals) {
  const Reconstruction model = RingModel(4, 5);
  BundleSelection selection;
  PhotoPrior& prior = selection.prior_of_image[2];
  prior.position_in_world = Eigen::Vector3d(1, 2, 3);
  prior.up_in_cam = Eigen::Vector3d(0.1, -0.9, 0.4).normalized();
  BundleState state = GatherBundle(selection, {}, {}, model);
  BundlePose& pose = state.poses[1];
  pose.turn_and_center[0] = 0.2;
  pose.turn_and_center[2] = -0.4;
  ExpectDerivatives(PositionPriorCost(prior), {pose.turn_and_center}, &state);
  ExpectDerivatives(UpPriorCost(pose, prior), {pose.turn_and_center}, &state);
}

TEST(BundlePose, ComesBackFromItsParameters) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d turn = Gaussian3(&random, 2);
    const Rigid3d pose{Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())),
                       Gaussian3(&random, 50)};
    BundlePose block;
    block.SetCamFromWorld(pose);
    const Eigen::Vector3d more = Gaussian3(&random, 1);
    std::copy_n(more.data(), 3, block.turn_and_center);
    block.Refresh();
    const Rigid3d turned = block.CamFromWorld();
    EXPECT_LT((turned.rotation.toRotationMatrix() - block.rotation).norm(), 1e-12);
    EXPECT_LT((CameraCenter(turned) - CameraCenter(pose)).norm(), 1e-11);
    EXPECT_NEAR(turned.rotation.angularDistance(pose.rotation),
                std::abs(std::remainder(more.norm(), 2 * std::numbers::pi)), 1e-7);
  }
}

}  // namespace
}  // namespace colmap_ext
