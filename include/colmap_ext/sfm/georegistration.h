// Puts a model into the world: a robust similarity from camera centres to measured positions.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct GeoregistrationOptions {
  // A photo whose measured position is further from its place in the model disagrees, is named and
  // left out; metres, > 0. Consumer GPS is within 5 m or so.
  double max_residual_m = 8.0;
  // Where the Cauchy loss starts to discount a residual, or twice the median residual where that is
  // more; metres, > 0.
  double loss_scale_m = 1.0;
  // The world may be tilted by at most so much (predicted from the residuals and from how far the
  // cameras lie from one line); degrees, (0, 45]. Beyond it, gravity is taken from the cameras.
  double max_tilt_deg = 3.0;
  // Cameras are taken to be free of roll (a drone's gimbal) within so much, where gravity is
  // needed; degrees, (0, 45].
  double level_roll_deg = 2.0;
  int ransac_samples = 500;  // >= 1
  std::uint64_t seed = 1;

  std::string Check() const;
};
void BindOptions(OptionSet& set, GeoregistrationOptions* options);  // section "Georegistration"

// A registered photo with a measured position.
struct MeasuredCamera {
  std::string name;
  Rigid3d cam_from_model;
  Eigen::Vector3d position_in_world;  // ENU, metres
  // Accuracy, one sigma, metres, > 0. Only their ratios count, among photos and against attitudes.
  double sigma_horizontal_m = 1.5;
  double sigma_vertical_m = 1.5;
  // The measured vertical: the world's z axis in the camera, unit length. Its sigma is
  // level_roll_deg.
  std::optional<Eigen::Vector3d> up_in_cam = std::nullopt;
};

struct PhotoResidual {
  std::string name;
  double residual_m = 0;  // distance
  Eigen::Vector3d offset_m =
      Eigen::Vector3d::Zero();  // place in the model - measured position, ENU
  bool is_outlier = false;
};

struct GeoregistrationResult {
  // world = *world_from_model * model; empty when no trustworthy similarity exists.
  std::optional<Sim3d> world_from_model;
  std::string refusal;                   // why it is empty, one clause
  double rms_m = 0;                      // of the photos that agree
  double max_m = 0;                      // ...
  int num_used = 0;                      // photos that agree
  double tilt_uncertainty_deg = 0;       // one sigma, predicted
  bool gravity_from_cameras = false;     // the positions alone did not fix the tilt
  int num_attitudes = 0;                 // photos whose measured vertical was used
  std::vector<PhotoResidual> outliers;   // photos that disagree, worst first
  std::vector<PhotoResidual> residuals;  // of all photos, in the order given
};

// Samples similarities (3 photos; 2 and level cameras where all centres are on a line), keeps the
// one that most photos agree with, and refines it with Ceres under a Cauchy loss, then without the
// photos that disagree. Refuses when fewer than 3 photos, or not more than half of them, agree, and
// when the tilt of the world stays unknown: positions on one line, cameras all looking across it.
// Measured verticals hold the tilt beside the positions, each by its accuracy. Exact input is
// recovered to rounding. Throws UsageError for invalid options, Error for a sigma or vertical out
// of its range.
GeoregistrationResult Georegister(const std::vector<MeasuredCamera>& cameras,
                                  const GeoregistrationOptions& options);

// How positions agree with a model that is in the world already (after an adjustment): the same
// report with the identity as similarity.
GeoregistrationResult ComparePositions(const std::vector<MeasuredCamera>& cameras,
                                       const GeoregistrationOptions& options);

// The text of sparse/georegistration.json (docs/file_formats.md): scale, residuals in metres,
// photos that disagree.
std::string GeoregistrationReport(const GeoregistrationResult& result);

}  // namespace colmap_ext
