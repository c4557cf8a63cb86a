// Bundle adjustment of a sparse model, whole or in part, held in the world by measured positions.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct BundleOptions {
  // Error of a keypoint, one sigma: what reprojection errors are divided by before they are weighed
  // against priors; px, > 0. Keypoints of one facade err together, hence more than the residuals.
  double keypoint_sigma_px = 1;
  double loss_scale_px = 0.5;  // where the soft L1 loss turns linear; px, >= 0, 0: squares
  // Where the Cauchy loss starts to discount a prior; in sigmas of the prior, > 0.
  double prior_loss_scale = 4;
  // What is estimated of the cameras; the photos of a camera share it.
  bool refine_focal_length = false;
  bool refine_principal_point = false;
  bool refine_extra_params = false;  // distortion
  int max_iterations = 50;           // of one round; >= 1
  double function_tolerance = 1e-5;  // relative change of the cost that ends a round; [0, 1)
  // Rounds of adjusting and filtering: the last one is that which filters less than
  // max_filtered_part of the observations; >= 1.
  int max_rounds = 3;
  double max_filtered_part = 5e-4;  // [0, 1]
  // As COLMAP's Mapper.filter_max_reproj_error and filter_min_tri_angle.
  double filter_max_error_px = 4;  // px, > 0
  // Observations are also dropped beyond so many times the median error, down to two
  // keypoint_sigma_px; >= 1.
  double filter_max_medians = 5;
  double filter_min_angle_deg = 1.5;  // degrees, [0, 90)

  std::string Check() const;  // "" when all is well
};
void BindOptions(OptionSet& set, BundleOptions* options);  // section "BundleAdjustment"

// What was measured about a photo beside its picture.
struct PhotoPrior {
  std::optional<Eigen::Vector3d> position_in_world =
      std::nullopt;                          // of the camera's centre; ENU, metres
  double sigma_horizontal_m = 1.5;           // > 0
  double sigma_vertical_m = 3;               // > 0
  std::optional<Eigen::Vector3d> up_in_cam;  // unit: the world's z axis, in the camera
  double up_sigma_rad = 0.02;                // > 0
};

struct BundleSelection {
  // The other photos keep their poses to the last bit; nullopt: all are free.
  std::optional<std::set<ImageId>> free_images;
  // nullopt: all points that free photos see. Points that are not free keep their places.
  std::optional<std::set<Point3DId>> free_points;
  // Photos without entry have no prior; those of photos that are not free are not used.
  std::map<ImageId, PhotoPrior> prior_of_image;
};

// A measured position that the adjusted model contradicts.
struct PriorDisagreement {
  ImageId image_id = 0;
  double residual_m = 0;
  double residual_sigmas = 0;
};

struct BundleResult {
  int num_free_images = 0;
  int num_free_points = 0;  // of the first round
  std::size_t num_observations = 0;
  int num_rounds = 0;
  int num_iterations = 0;  // of all rounds
  bool converged = false;  // the last round ended by its tolerance
  // Root mean square reprojection error (length of the vector) of the observations used, before the
  // first round and after the last one, filtered ones left out.
  double initial_rms_px = 0;
  double final_rms_px = 0;
  double prior_rms_m = 0;  // of the positions, after the last round, disagreeing ones left out
  std::vector<PriorDisagreement> disagreements;  // above 5 sigmas, worst first
  std::size_t num_filtered_observations = 0;
  std::size_t num_filtered_points = 0;
  // Cameras whose estimated intrinsics were absurd (focal length outside of 0.1 ... 10 times the
  // longer side, or distortion above 1): all was adjusted again with their given ones.
  std::vector<CameraId> refused_cameras;
};

// Minimises  sum soft_l1(|project(X) - x|² / keypoint_sigma²) + sum cauchy(priors)  over poses and
// points (Levenberg-Marquardt, Schur complement, Ceres on one thread: the same result on every
// run), then drops the observations and points that fail the filters and sets error_px of the
// points that it touched. Work and memory depend on the free photos and the points that they see,
// not on the size of the model. With nothing to hold the gauge (no fixed photo or point, fewer than
// three positions) the model is put back by the similarity that brings the photos to where they
// were. In the world of the priors: metres; without priors any unit will do.
// Throws UsageError for invalid options; Error for an unknown id in `selection`, a prior that is
// not finite, and a camera without positive focal length; CancelledError when `job` is cancelled
// (the model is then as before).
BundleResult AdjustBundle(const BundleSelection& selection, const BundleOptions& options,
                          const JobControl& job, Reconstruction* model);

}  // namespace colmap_ext
