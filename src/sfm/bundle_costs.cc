#include "bundle_costs.h"

#include <cmath>

namespace colmap_ext {
namespace {

using PoseJacobian = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;
using PointJacobian = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using CameraJacobian = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

Eigen::Vector3d PriorWeights(const PhotoPrior& prior) {
  return {1 / prior.sigma_horizontal_m, 1 / prior.sigma_horizontal_m, 1 / prior.sigma_vertical_m};
}

}  // namespace

void RefreshState::PrepareForEvaluation(bool, bool new_evaluation_point) {
  if (!new_evaluation_point) return;
  for (BundlePose& pose : state_->poses) {
    if (pose.is_free) pose.Refresh();
  }
  for (BundleCamera& camera : state_->cameras) camera.Refresh();
}

ReprojectionCost::ReprojectionCost(const BundleState& state, const BundleObservation& observation,
                                   double sigma_px)
    : pose_(&state.poses[observation.pose]),
      camera_(&state.cameras[pose_->camera]),
      point_(&state.points[observation.point]),
      pixel_(observation.pixel),
      weight_(1 / sigma_px) {
  set_num_residuals(2);
  if (pose_->is_free) mutable_parameter_block_sizes()->push_back(6);
  if (point_->is_free) mutable_parameter_block_sizes()->push_back(3);
  if (!camera_->free_params.empty()) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(camera_->free_params.size()));
  }
}

bool ReprojectionCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  const Eigen::Vector3d in_cam = pose_->rotation * (point_->position - pose_->center());
  if (std::abs(in_cam.z()) < 1e-12) return false;  // Ceres tries a shorter step
  const double inverse_z = 1 / in_cam.z();
  const Eigen::Vector2d normalized = in_cam.head<2>() * inverse_z;
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  if (jacobians == nullptr) {
    residual = weight_ * (ImageFromNormalized(camera_->camera, normalized) - pixel_);
    return true;
  }
  ProjectionDerivatives derivatives;
  residual = weight_ * (ImageFromNormalized(camera_->camera, normalized, &derivatives) - pixel_);
  PointJacobian by_in_cam;
  by_in_cam.leftCols<2>() = (weight_ * inverse_z) * derivatives.by_normalized;
  by_in_cam.col(2) = -(by_in_cam.leftCols<2>() * normalized);
  const PointJacobian by_point = by_in_cam * pose_->rotation;
  int block = 0;
  if (pose_->is_free) {
    if (jacobians[block] != nullptr) {
      Eigen::Map<PoseJacobian> by_pose(jacobians[block]);
      by_pose.leftCols<3>().noalias() = -(by_in_cam * Cross(in_cam)) * pose_->turn_jacobian;
      by_pose.rightCols<3>() = -by_point;
    }
    ++block;
  }
  if (point_->is_free) {
    if (jacobians[block] != nullptr) {
      Eigen::Map<PointJacobian> block_by_point(jacobians[block]);
      block_by_point = by_point;
    }
    ++block;
  }
  const std::vector<int>& free_params = camera_->free_params;
  if (free_params.empty() || jacobians[block] == nullptr) return true;
  const auto num_free = static_cast<Eigen::Index>(free_params.size());
  Eigen::Map<CameraJacobian> by_camera(jacobians[block], 2, num_free);
  for (Eigen::Index k = 0; k < num_free; ++k) {
    by_camera.col(k) =
        weight_ * derivatives.by_params.col(free_params[static_cast<std::size_t>(k)]);
  }
  return true;
}

Eigen::Vector3d PositionResidualSigmas(const PhotoPrior& prior, const Eigen::Vector3d& center) {
  return PriorWeights(prior).cwiseProduct(center - *prior.position_in_world);
}

bool PositionPriorCost::Evaluate(double const* const* parameters, double* residuals,
                                 double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> center(parameters[0] + 3);
  Eigen::Map<Eigen::Vector3d>(residuals, 3) = PositionResidualSigmas(prior_, center);
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> by_pose(jacobians[0]);
  by_pose.leftCols<3>().setZero();
  by_pose.rightCols<3>() = PriorWeights(prior_).asDiagonal();
  return true;
}

bool UpPriorCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  const Eigen::Vector3d up = pose_.rotation.col(2);
  const double weight = 1 / prior_.up_sigma_rad;
  Eigen::Map<Eigen::Vector3d>(residuals, 3) = weight * (up - *prior_.up_in_cam);
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> by_pose(jacobians[0]);
  by_pose.leftCols<3>() = -weight * Cross(up) * pose_.turn_jacobian;
  by_pose.rightCols<3>().setZero();
  return true;
}

}  // namespace colmap_ext
