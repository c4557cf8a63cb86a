// How far a model is from the truth (paper, Sec. "Evaluation Metric").
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/eval/alignment.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct EvaluationOptions {
  // Poisson-disk radius of the samples on the truth and on the model (metres, > 0).
  double sample_spacing_m = 0.1;
  // Distances at which completeness and accuracy are given, each with its unit (mm, cm, m, in; mm
  // when there is none), > 0, separated by commas. The paper's are 1 and 2 inch.
  std::string thresholds = "1in,2in";
  // "surface": nearest point of the model's triangles. "vertex": nearest vertex, as the paper does;
  // it charges a coarsely meshed model for its wide vertices, so it is not the default. A model
  // without faces is always measured to its vertices.
  std::string distance = "surface";
  // Errors above this count as this in the capped mean and RMS (metres, > 0), so that a few holes
  // do not hide how exact the rest is.
  double cap_m = 0.5;
  // The part of the model that is judged for accuracy: inside the bounds of the truth grown by this
  // (metres, >= 0). What the model holds elsewhere (ground, neighbours) is no error.
  double margin_m = 0.5;
  // Samples lower than this above the lowest point of the truth are left out on both sides (metres,
  // >= 0; 0: off): for models with the ground that an object stands on while the truth has none.
  double ground_cut_m = 0;
  // A sample of the truth counts as seen when so many photos see it (>= 1); stereo needs two.
  int min_views = 2;
  std::uint64_t seed = 1;  // of the samples
  IcpOptions icp;          // used by those who align; EvaluateModel compares the meshes as given

  std::string Check() const;
  // Parsed thresholds, in metres, ascending. Throws UsageError when they cannot be parsed.
  std::vector<double> ThresholdsM() const;
};

// Section "ModelEvaluator".
void BindOptions(OptionSet& set, EvaluationOptions* options);

// Errors of a set of samples of the truth: distances to the model.
struct ErrorSummary {
  std::size_t samples = 0;  // 0: everything below is 0
  double mean_m = 0;
  double rms_m = 0;
  double median_m = 0;
  double percentile90_m = 0;
  double capped_mean_m = 0;  // each error limited to cap_m
  double capped_rms_m = 0;
  std::vector<double> completeness;  // share below each threshold (paper's eq.), 0 … 1
};

// Shares between 0 and 1.
struct ThresholdScore {
  double threshold_m = 0;
  double completeness = 0;  // truth samples with the model nearer than the threshold: paper's eq.
  double accuracy = 0;      // model samples with the truth nearer than the threshold
  double f_score = 0;       // harmonic mean of both; 0 when both are 0
};

struct EvaluationResult {
  ErrorSummary errors;                 // over ALL samples of the truth, as the paper does
  std::vector<ThresholdScore> scores;  // one a threshold, ascending
  // Of the samples that enough photos see, and of the others; only when the views were counted.
  std::optional<ErrorSummary> seen;
  std::optional<ErrorSummary> unseen;

  std::vector<SurfaceSample> truth_samples;
  std::vector<double> truth_error_m;  // one a truth sample: distance to the model
  std::vector<Eigen::Vector3d> model_samples;
  std::vector<double> model_error_m;  // one a model sample: distance to the truth
};

// Compares two meshes in the same frame; either may be a cloud (vertices only). Distances to a
// cloud are those to its nearest point. `region`: only what lies in it is judged, on both sides.
// Throws UsageError for a bad option, Error when the truth or the model is empty or nothing of the
// truth lies in the region.
EvaluationResult EvaluateModel(const TriangleMesh& model, const TriangleMesh& truth,
                               const EvaluationOptions& options, const JobControl& job,
                               const std::optional<BoundingBox>& region = std::nullopt);

// Fills `seen` and `unseen` from the number of photos that see each truth sample (CountViews).
void SplitBySeen(const std::vector<int>& num_views, const EvaluationOptions& options,
                 EvaluationResult* result);

// Distance of each point to the truth: to its surface, or to its nearest point when it has no
// faces. Throws Error when the truth is empty.
std::vector<double> DistancesTo(const TriangleMesh& truth,
                                const std::vector<Eigen::Vector3d>& points);

// What was done before EvaluateModel to bring the model into the truth's frame.
struct ModelAlignment {
  Sim3d truth_from_model;
  std::optional<CameraAlignment> cameras;
  std::optional<IcpResult> icp;
};

// Cameras first when `pairs` is not empty, then ICP when options.icp.max_iterations > 0.
ModelAlignment AlignModel(const TriangleMesh& model, const TriangleMesh& truth,
                          const std::vector<CameraPair>& pairs, const EvaluationOptions& options,
                          const JobControl& job);

// JSON text of <evaluation>.json: {"scale", "mean_error_m", "rms_error_m", "completeness":
// {"25.4mm": …}, "accuracy": {…}, "f_score": {…}, "samples", …, "seen": {"share", …}, "unseen":
// {…}, "alignment"}. Shares are between 0 and 1.
std::string EvaluationToJson(const EvaluationResult& result, const ModelAlignment& alignment,
                             const EvaluationOptions& options);

// Key of a threshold in JSON files: 0.0254 -> "25.4mm".
std::string ThresholdKey(double threshold_m);

}  // namespace colmap_ext
