#include "similarity_sampling.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

Sim3d FitSimilarity(const std::vector<CameraObservation>& cameras,
                    const std::vector<std::size_t>& indices) {
  Eigen::Matrix3Xd model(3, indices.size()), world(3, indices.size());
  for (std::size_t k = 0; k < indices.size(); ++k) {
    model.col(static_cast<Eigen::Index>(k)) = cameras[indices[k]].center_in_model;
    world.col(static_cast<Eigen::Index>(k)) = cameras[indices[k]].position_in_world;
  }
  return EstimateSimilarity(model, world);
}

// Whether the corners span a triangle worth a hypothesis: height above 1 % of the longest side.
bool IsTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double longest =
      std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
  return longest > 0 && (b - a).cross(c - a).norm() > 0.01 * longest;
}

std::optional<Sim3d> FromThree(const std::vector<CameraObservation>& cameras,
                               const std::array<std::size_t, 3>& pick) {
  const CameraObservation &a = cameras[pick[0]], &b = cameras[pick[1]], &c = cameras[pick[2]];
  if (!IsTriangle(a.center_in_model, b.center_in_model, c.center_in_model)) return std::nullopt;
  if (!IsTriangle(a.position_in_world, b.position_in_world, c.position_in_world)) {
    return std::nullopt;
  }
  return FitSimilarity(cameras, {pick.begin(), pick.end()});
}

// Height of a vector turned about a unit axis by theta: constant + cosine cos + sine sin.
struct TurnedHeight {
  TurnedHeight(const Eigen::Vector3d& vector, const Eigen::Vector3d& axis)
      : constant(axis.dot(vector) * axis.z()),
        cosine(vector.z() - constant),
        sine(axis.cross(vector).z()) {}
  double At(double theta) const {
    return constant + cosine * std::cos(theta) + sine * std::sin(theta);
  }
  double SlopeAt(double theta) const { return sine * std::cos(theta) - cosine * std::sin(theta); }
  double constant, cosine, sine;
};

// Turn about `axis` that makes the cameras' right axes level, images not upside down.
double LevelingTurn(const std::vector<CameraObservation>& cameras,
                    const Eigen::Quaterniond& world_from_model, const Eigen::Vector3d& axis) {
  std::vector<TurnedHeight> rights, downs;
  for (const CameraObservation& camera : cameras) {
    rights.emplace_back(world_from_model * camera.right_in_model, axis);
    downs.emplace_back(world_from_model * camera.down_in_model, axis);
  }
  constexpr int kSteps = 360;
  double best_theta = 0, best_cost = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kSteps; ++step) {
    const double theta = 2 * std::numbers::pi * step / kSteps;
    double cost = 0, down_height = 0;
    for (std::size_t k = 0; k < rights.size(); ++k) {
      cost += std::abs(rights[k].At(theta));  // one rolled camera must not decide
      down_height += downs[k].At(theta);
    }
    if (down_height < 0 && cost < best_cost) {
      best_cost = cost;
      best_theta = theta;
    }
  }
  for (int iteration = 0; iteration < 10; ++iteration) {  // Gauss-Newton
    double gradient = 0, curvature = 1e-12;
    for (const TurnedHeight& right : rights) {
      gradient += right.SlopeAt(best_theta) * right.At(best_theta);
      curvature += right.SlopeAt(best_theta) * right.SlopeAt(best_theta);
    }
    best_theta -= gradient / curvature;
  }
  return best_theta;
}

std::optional<Sim3d> FromTwo(const std::vector<CameraObservation>& cameras, std::size_t first,
                             std::size_t second, double least_distance) {
  const CameraObservation &a = cameras[first], &b = cameras[second];
  const Eigen::Vector3d in_model = b.center_in_model - a.center_in_model;
  const Eigen::Vector3d in_world = b.position_in_world - a.position_in_world;
  if (in_model.norm() <= least_distance || in_world.norm() <= 0) return std::nullopt;
  Sim3d similarity;
  similarity.scale = in_world.norm() / in_model.norm();
  similarity.rotation = Eigen::Quaterniond::FromTwoVectors(in_model, in_world);
  const Eigen::Vector3d axis = in_world.normalized();
  const double turn = LevelingTurn(cameras, similarity.rotation, axis);
  similarity.rotation =
      (Eigen::Quaterniond(Eigen::AngleAxisd(turn, axis)) * similarity.rotation).normalized();
  similarity.translation =
      0.5 * (a.position_in_world + b.position_in_world) -
      similarity.scale * (similarity.rotation * (0.5 * (a.center_in_model + b.center_in_model)));
  return similarity;
}

double TruncatedCost(const Sim3d& world_from_model, const std::vector<CameraObservation>& cameras,
                     double max_residual_m) {
  double cost = 0;
  for (const CameraObservation& camera : cameras) {
    const double residual = std::min(ResidualOf(world_from_model, camera), max_residual_m);
    cost += residual * residual;
  }
  return cost;
}

void RequireSound(const MeasuredCamera& camera) {
  if (!(camera.sigma_horizontal_m > 0 && camera.sigma_vertical_m > 0)) {
    throw Error(camera.name + ": the sigmas of its measured position must be above 0 m");
  }
  if (camera.up_in_cam && !(std::abs(camera.up_in_cam->norm() - 1) < 1e-6)) {
    throw Error(camera.name + ": its measured vertical is not of unit length");
  }
}

void LevelByVertical(const Eigen::Vector3d& up_in_model, CameraObservation* observation) {
  const Eigen::Vector3d right = observation->right_in_model;
  Eigen::Vector3d level = right - right.dot(up_in_model) * up_in_model;
  if (level.norm() < 0.1) level = observation->down_in_model.cross(up_in_model);  // on its side
  observation->right_in_model = level.normalized();
  observation->down_in_model = -up_in_model;
  observation->forward_in_model = up_in_model.cross(observation->right_in_model);
}

}  // namespace

double CommonSigma(const std::vector<MeasuredCamera>& cameras) {
  std::vector<double> sigmas;
  for (const MeasuredCamera& camera : cameras) sigmas.push_back(camera.sigma_horizontal_m);
  return MiddleValue(std::move(sigmas));
}

std::vector<CameraObservation> ObservationsOf(const std::vector<MeasuredCamera>& cameras) {
  for (const MeasuredCamera& camera : cameras) RequireSound(camera);
  const double common = CommonSigma(cameras);
  std::vector<CameraObservation> observations;
  for (const MeasuredCamera& camera : cameras) {
    const Eigen::Quaterniond model_from_cam = camera.cam_from_model.rotation.conjugate();
    CameraObservation observation = {
        CameraCenter(camera.cam_from_model),
        model_from_cam * Eigen::Vector3d::UnitX(),
        model_from_cam * Eigen::Vector3d::UnitY(),
        camera.position_in_world,
        {common / camera.sigma_horizontal_m, common / camera.sigma_horizontal_m,
         common / camera.sigma_vertical_m},
        std::nullopt};
    if (camera.up_in_cam) LevelByVertical(model_from_cam * *camera.up_in_cam, &observation);
    observations.push_back(observation);
  }
  return observations;
}

double ResidualOf(const Sim3d& world_from_model, const CameraObservation& camera) {
  return (world_from_model * camera.center_in_model - camera.position_in_world).norm();
}

Eigen::Vector3d PrincipalExtents(const std::vector<CameraObservation>& cameras) {
  Eigen::Matrix3Xd centers(3, cameras.size());
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    centers.col(static_cast<Eigen::Index>(k)) = cameras[k].center_in_model;
  }
  centers.colwise() -= centers.rowwise().mean().eval();
  Eigen::Vector3d extents = Eigen::Vector3d::Zero();
  const Eigen::VectorXd values = centers.jacobiSvd().singularValues();
  extents.head(values.size()) = values / std::sqrt(static_cast<double>(cameras.size()));
  return extents;
}

double LevelStiffness(const std::vector<CameraObservation>& cameras, const Sim3d& world_from_model,
                      const Eigen::Vector3d& axis_in_world) {
  double sum = 0;
  for (const CameraObservation& camera : cameras) {
    const double slope = axis_in_world.cross(world_from_model.rotation * camera.right_in_model).z();
    sum += slope * slope;
    if (!camera.forward_in_model) continue;
    const double forward_slope =
        axis_in_world.cross(world_from_model.rotation * *camera.forward_in_model).z();
    sum += forward_slope * forward_slope;
  }
  return std::sqrt(sum / static_cast<double>(cameras.size()));
}

std::optional<Sim3d> SampleSimilarity(const std::vector<CameraObservation>& cameras,
                                      bool level_cameras, const GeoregistrationOptions& options) {
  std::mt19937_64 generator(options.seed);
  const std::size_t count = cameras.size();
  const double least_distance = 0.5 * PrincipalExtents(cameras)(0);
  std::optional<Sim3d> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (int sample = 0; sample < options.ransac_samples; ++sample) {
    const std::array<std::size_t, 3> pick = {generator() % count, generator() % count,
                                             generator() % count};
    const std::optional<Sim3d> hypothesis = level_cameras
                                                ? FromTwo(cameras, pick[0], pick[1], least_distance)
                                                : FromThree(cameras, pick);
    if (!hypothesis) continue;
    const double cost = TruncatedCost(*hypothesis, cameras, options.max_residual_m);
    if (cost < best_cost) {
      best_cost = cost;
      best = hypothesis;
    }
  }
  return best;
}

}  // namespace colmap_ext
