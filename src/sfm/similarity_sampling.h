// Hypotheses for georegistration: similarities from as few photos as possible.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/sfm/georegistration.h"

namespace colmap_ext {

// A camera reduced to what georegistration needs.
struct CameraObservation {
  Eigen::Vector3d center_in_model;
  Eigen::Vector3d right_in_model;  // unit: the image's x axis, level when the camera has no roll
  Eigen::Vector3d down_in_model;   // unit: the image's y axis
  Eigen::Vector3d position_in_world;
  // Sigma that the fit is scaled to, over that of each axis: 1 for photos of common accuracy.
  Eigen::Vector3d weights = Eigen::Vector3d::Ones();
  // Unit, level and at right angles to right_in_model; only where the vertical was measured. Right
  // is then level by measurement, not because the camera has no roll.
  std::optional<Eigen::Vector3d> forward_in_model;
};
// Throws Error for a sigma that is not above 0 and a vertical that is not of unit length.
std::vector<CameraObservation> ObservationsOf(const std::vector<MeasuredCamera>& cameras);
// Median horizontal sigma, metres; what weights are relative to.
double CommonSigma(const std::vector<MeasuredCamera>& cameras);

double ResidualOf(const Sim3d& world_from_model, const CameraObservation& camera);  // metres

// Root mean square extents of the centres along their principal axes, largest first, model units.
Eigen::Vector3d PrincipalExtents(const std::vector<CameraObservation>& cameras);

// How firmly level cameras hold the rotation of the model about an axis of the world: root mean
// square height change of their right axes per radian; 0 (not at all) … 1.
double LevelStiffness(const std::vector<CameraObservation>& cameras, const Sim3d& world_from_model,
                      const Eigen::Vector3d& axis_in_world);

// The sampled similarity with the least sum of squared residuals, each counted up to
// max_residual_m. With `level_cameras`, two photos and the level cameras make a sample, else three
// photos that are not on one line. Empty when there is no sample.
std::optional<Sim3d> SampleSimilarity(const std::vector<CameraObservation>& cameras,
                                      bool level_cameras, const GeoregistrationOptions& options);

}  // namespace colmap_ext
