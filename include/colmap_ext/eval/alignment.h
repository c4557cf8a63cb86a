// Registration of a reconstructed model to its ground truth (paper, Sec. "Model Alignment"): first
// the camera centres, then ICP.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// One photo whose camera centre is known in both frames.
struct CameraPair {
  std::string name;
  Eigen::Vector3d center_in_model = Eigen::Vector3d::Zero();
  Eigen::Vector3d center_in_truth = Eigen::Vector3d::Zero();
};

// The photos of `model` that `truth_cam_from_world` knows by the same name, sorted by name.
std::vector<CameraPair> PairCameras(const Reconstruction& model,
                                    const std::map<std::string, Rigid3d>& truth_cam_from_world);

struct CameraAlignment {
  Sim3d truth_from_model;
  double rms_m = 0;                   // over the pairs that were used
  std::vector<std::string> rejected;  // photos whose centre contradicts the others
};

// Least-squares similarity (Umeyama 1991) of the centres: the paper's T_init. Pairs more than five
// times the median residual away are left out and the rest is fitted again, so that one photo
// registered at a wrong place does not bend the frame. Throws Error when fewer than 3 pairs are
// given or they are collinear.
CameraAlignment AlignByCameras(const std::vector<CameraPair>& pairs);

struct IcpOptions {
  int max_iterations = 60;      // 0 … 10000; 0: keep the start
  double trim = 0.2;            // share of the worst correspondences left out, 0 … 0.9
  double max_distance_m = 1.0;  // correspondences further apart are left out, > 0
  bool with_scale = true;       // also estimate the scale
  int num_samples = 20000;      // points on the truth, 100 … 10 million
  std::uint64_t seed = 1;       // of the samples
  // How far off the start may be, metres, >= 0: what lies much further apart is missing on one
  // side, not displaced. 0: not known.
  double start_error_m = 0;

  std::string Check() const;
};

struct IcpResult {
  Sim3d truth_from_model;
  int iterations = 0;
  bool converged = false;  // the last step moved the model by less than 1e-9 of its size
  // RMS of the trimmed correspondences along the normals of the truth, not weighted, at the start
  // and at the end. It may rise where the truth has much that the model has not.
  double start_rms_m = 0;
  double rms_m = 0;
};

// Refines `start` by trimmed point-to-plane ICP with scale (Chen and Medioni 1992; Chetverikov et
// al. 2002) and robust weights: each truth sample with its normal against the nearest point of the
// model (of its surface, or of its vertices when it has no faces). Samples are taken on the truth,
// so that what the model has beside the truth (ground) takes no part. Half of a truth may be what
// no photo saw (undersides, insides): a sample counts only where the model's surface faces within
// 60° of its normal (either way round, when the two are not wound alike), and its residual r with
// the weight of Geman and McClure, 1 / (1 + (r/s)²)², s twice the weighted RMS residual, at first
// not more than five times start_error_m (or 0.2 % of the truth's diagonal, if that is more). The
// result is `start` itself where that fits better: RMS over all samples, distances limited to s.
// Directions that the shape does not determine stay as they were. Throws Error when either side is
// empty or no sample has the model within max_distance_m.
IcpResult RefineByIcp(const TriangleMesh& model, const TriangleMesh& truth,
                      const Sim3d& truth_from_model_start, const IcpOptions& options,
                      const JobControl& job);

// Every vertex moved.
TriangleMesh TransformMesh(const Sim3d& b_from_a, const TriangleMesh& mesh_in_a);

}  // namespace colmap_ext
