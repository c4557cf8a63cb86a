#include "colmap_ext/eval/alignment.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "colmap_ext/util/statistics.h"
#include "nearest.h"
#include "samples.h"

namespace colmap_ext {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// Directions of the normal equations weaker than this share of the strongest are not determined by
// the shape (a plane slides, a sphere turns) and stay as they are.
constexpr double kUndetermined = 1e-7;

// A sample and the model's surface beside it belong together when their normals are within 60°. The
// underside of a roof that no photo saw would else pull at the roof's top.
constexpr double kMinNormalCosine = 0.5;

// A truth sample and the nearest model point, both in the truth frame.
struct Correspondence {
  Eigen::Vector3d model_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d truth_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d truth_normal = Eigen::Vector3d::Zero();
  double distance = std::numeric_limits<double>::infinity();
  double normal_cosine = 1;  // 1 where the model has no normals
};

// The scale of the weights is twice the weighted RMS residual, and shrinks to it step by step, so
// that a displacement is mended before what it made far apart loses its weight.
constexpr double kScaleOfRms = 2;
constexpr double kScaleShrinkage = 0.7;
constexpr double kScaleOfStartError = 5;
constexpr double kLeastScaleOfSize = 0.002;

// Along the normal of the truth.
double Residual(const Correspondence& c) {
  return c.truth_normal.dot(c.model_point - c.truth_point);
}

// Of a residual, 0 … 1 (Geman and McClure).
double RobustWeight(double residual, double scale) {
  const double ratio = scale > 0 ? residual / scale : 0;
  return 1 / ((1 + ratio * ratio) * (1 + ratio * ratio));
}

// Of the residuals, each with its weight; an infinite scale weighs all alike. 0 without matches.
double WeightedRms(const std::vector<Correspondence>& matches, double scale) {
  double sum = 0, weights = 0;
  for (const Correspondence& c : matches) {
    const double residual = Residual(c), weight = RobustWeight(residual, scale);
    sum += weight * residual * residual;
    weights += weight;
  }
  return weights > 0 ? std::sqrt(sum / weights) : 0;
}

struct IcpStep {
  Sim3d new_from_old;
  double moved_m = 0;
};

class Icp {
 public:
  Icp(const TriangleMesh& model, const TriangleMesh& truth, const Sim3d& truth_from_model_start,
      const IcpOptions& options)
      : options_(options),
        samples_(
            SamplesWithNormals(truth, static_cast<std::size_t>(options.num_samples), options.seed)),
        finder_(model, false) {
    if (model.vertices.empty()) throw Error("ICP: the model is empty");
    if (samples_.empty()) throw Error("ICP: the ground truth has no surface");
    size_m_ = BoundsOf(truth).diagonal().norm();
    for (std::size_t i = 0; i < model.faces.size(); ++i) {
      model_normals_.push_back(FaceNormal(model, i));
    }
    start_ = MatchAll(truth_from_model_start);
    winding_ = WindingOf(start_);
  }

  double size_m() const { return size_m_; }

  // Of the weights, where the start is known to be good.
  double LargestScale() const {
    if (options_.start_error_m == 0) return std::numeric_limits<double>::infinity();
    return std::max(kScaleOfStartError * options_.start_error_m, kLeastScaleOfSize * size_m_);
  }

  // Of every sample, at the start.
  const std::vector<Correspondence>& start() const { return start_; }

  // Of every sample the nearest point of the model; at infinity beyond the distance limit.
  std::vector<Correspondence> MatchAll(const Sim3d& truth_from_model) const {
    const Sim3d model_from_truth = Inverse(truth_from_model);
    const double max_in_model = options_.max_distance_m * model_from_truth.scale;
    std::vector<Correspondence> all(samples_.size());
    ParallelFor(samples_.size(), [&](std::size_t i) {
      const SurfaceSample& sample = samples_[i];
      const auto found = finder_.Find(model_from_truth * sample.position, max_in_model);
      if (!found) return;
      all[i] = {truth_from_model * found->position, sample.position, sample.normal,
                found->distance * truth_from_model.scale};
      if (found->face < 0) return;
      const Eigen::Vector3d& normal = model_normals_[static_cast<std::size_t>(found->face)];
      all[i].normal_cosine = sample.normal.dot(truth_from_model.rotation * normal);
    });
    if (std::ranges::none_of(all,
                             [](const Correspondence& c) { return std::isfinite(c.distance); })) {
      throw Error("ICP: the model lies nowhere within " + std::to_string(options_.max_distance_m) +
                  " m of the ground truth; check that both are in one frame, or give the cameras "
                  "of both (--input_path, --camera_path)");
    }
    return all;
  }

  // The admitted ones of `matches`, one a sample, that survive the trim. Their choice and order are
  // the same whatever the number of threads.
  std::vector<Correspondence> Trimmed(std::vector<Correspondence> matches) const {
    std::erase_if(matches, [&](const Correspondence& c) { return !IsAdmitted(c); });
    if (matches.empty()) return matches;
    std::vector<double> distances;
    for (const Correspondence& c : matches) distances.push_back(c.distance);
    const auto kept = static_cast<std::ptrdiff_t>(
        std::ceil((1.0 - options_.trim) * static_cast<double>(distances.size())));
    const auto cut = distances.begin() + kept - 1;
    std::nth_element(distances.begin(), cut, distances.end());
    const double limit = *cut;
    std::erase_if(matches, [&](const Correspondence& c) { return c.distance > limit; });
    return matches;
  }

  // Over all samples' `matches`; distances above `limit_m`, and samples without an admitted
  // correspondence, count as `limit_m`, so that a transform cannot look better by losing samples.
  double LimitedRms(const std::vector<Correspondence>& matches, double limit_m) const {
    double sum = 0;
    for (const Correspondence& c : matches) {
      const double distance = IsAdmitted(c) ? std::min(c.distance, limit_m) : limit_m;
      sum += distance * distance;
    }
    return std::sqrt(sum / static_cast<double>(samples_.size()));
  }

  // One Gauss-Newton step on Σ w (nᵀ(T p - q))², w the robust weight at `scale`, over rotation, log
  // scale and translation about the centre of the matches, all in metres at their RMS radius.
  IcpStep Step(const std::vector<Correspondence>& matches, double scale) const {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Correspondence& c : matches) center += c.model_point;
    center /= static_cast<double>(matches.size());
    double radius2 = 0;
    for (const Correspondence& c : matches) radius2 += (c.model_point - center).squaredNorm();
    const double radius = std::max(std::sqrt(radius2 / static_cast<double>(matches.size())), 1e-12);

    Matrix7d hessian = Matrix7d::Zero();
    Vector7d gradient = Vector7d::Zero();
    for (const Correspondence& c : matches) {
      const Eigen::Vector3d arm = (c.model_point - center) / radius;
      Vector7d row;
      row << arm.cross(c.truth_normal), c.truth_normal,
          options_.with_scale ? arm.dot(c.truth_normal) : 0.0;
      const double residual = Residual(c), weight = RobustWeight(residual, scale);
      hessian += weight * row * row.transpose();
      gradient += weight * residual * row;
    }
    const Vector7d x = SolveDetermined(hessian, -gradient);
    const Eigen::Vector3d turn = x.head<3>() / radius;
    Sim3d step;
    step.scale = std::exp(x[6] / radius);
    const double angle = turn.norm();
    if (angle > 0) step.rotation = Eigen::AngleAxisd(angle, turn / angle);
    step.translation = center + x.segment<3>(3) - step.scale * (step.rotation * center);
    return {step, x.norm()};
  }

 private:
  // 1: both meshes are wound alike, -1: the other way round, 0: no telling (a cloud's normals).
  static int WindingOf(const std::vector<Correspondence>& all) {
    const auto count = [&](double sign) {
      return std::ranges::count_if(all, [&](const Correspondence& c) {
        return std::isfinite(c.distance) && sign * c.normal_cosine >= kMinNormalCosine;
      });
    };
    const auto alike = count(1), opposite = count(-1);
    if (alike >= 2 * opposite) return 1;
    return opposite >= 2 * alike ? -1 : 0;
  }

  bool IsAdmitted(const Correspondence& c) const {
    const double cosine = winding_ == 0 ? std::abs(c.normal_cosine) : winding_ * c.normal_cosine;
    return std::isfinite(c.distance) && cosine >= kMinNormalCosine;
  }

  static Vector7d SolveDetermined(const Matrix7d& hessian, const Vector7d& rhs) {
    const Eigen::SelfAdjointEigenSolver<Matrix7d> solver(hessian);
    const double limit = kUndetermined * solver.eigenvalues().maxCoeff();
    Vector7d x = Vector7d::Zero();
    for (int i = 0; i < 7; ++i) {
      if (solver.eigenvalues()[i] <= limit) continue;
      const auto direction = solver.eigenvectors().col(i);
      x += direction * (direction.dot(rhs) / solver.eigenvalues()[i]);
    }
    return x;
  }

  IcpOptions options_;
  std::vector<SurfaceSample> samples_;
  NearestFinder finder_;
  std::vector<Eigen::Vector3d> model_normals_;  // one a face, model frame
  double size_m_ = 0;                           // diagonal of the truth
  std::vector<Correspondence> start_;           // one a sample
  int winding_ = 1;                             // as WindingOf
};

}  // namespace

std::vector<CameraPair> PairCameras(const Reconstruction& model,
                                    const std::map<std::string, Rigid3d>& truth_cam_from_world) {
  std::vector<CameraPair> pairs;
  for (const auto& [image_id, image] : model.images) {
    const auto truth = truth_cam_from_world.find(image.name);
    if (truth == truth_cam_from_world.end()) continue;
    pairs.push_back({image.name, CameraCenter(image.cam_from_world), CameraCenter(truth->second)});
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const CameraPair& a, const CameraPair& b) { return a.name < b.name; });
  return pairs;
}

CameraAlignment AlignByCameras(const std::vector<CameraPair>& pairs) {
  if (pairs.size() < 3) {
    throw Error("alignment by cameras needs 3 photos known on both sides, but only " +
                std::to_string(pairs.size()) + " have the same name in both");
  }
  std::vector<bool> used(pairs.size(), true);
  CameraAlignment result;
  for (int round = 0; round < 10; ++round) {
    const auto count = std::count(used.begin(), used.end(), true);
    Eigen::Matrix3Xd model(3, count), truth(3, count);
    for (std::size_t i = 0, column = 0; i < pairs.size(); ++i) {
      if (!used[i]) continue;
      model.col(static_cast<Eigen::Index>(column)) = pairs[i].center_in_model;
      truth.col(static_cast<Eigen::Index>(column++)) = pairs[i].center_in_truth;
    }
    result.truth_from_model = EstimateSimilarity(model, truth);

    std::vector<double> residual(pairs.size());
    double sum = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      residual[i] =
          (result.truth_from_model * pairs[i].center_in_model - pairs[i].center_in_truth).norm();
      if (used[i]) sum += residual[i] * residual[i];
    }
    result.rms_m = std::sqrt(sum / static_cast<double>(count));
    // The floor keeps rounding from rejecting exact pairs.
    const double extent = (truth.colwise() - truth.rowwise().mean()).colwise().norm().maxCoeff();
    const double limit = std::max(5.0 * MiddleValue(residual), 1e-6 * extent);
    std::vector<bool> next(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) next[i] = residual[i] <= limit;
    if (next == used || std::count(next.begin(), next.end(), true) < 3) break;
    used = next;
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!used[i]) result.rejected.push_back(pairs[i].name);
  }
  return result;
}

std::string IcpOptions::Check() const {
  if (max_iterations < 0 || max_iterations > 10000) return "icp_iterations must be 0 … 10000";
  if (!(trim >= 0 && trim <= 0.9)) return "icp_trim must be between 0 and 0.9";
  if (!(max_distance_m > 0)) return "icp_max_distance_m must be above 0";
  if (!(start_error_m >= 0)) return "the error of ICP's start must be >= 0";
  if (num_samples < 100 || num_samples > 10000000) return "icp_samples must be 100 … 10000000";
  return "";
}

IcpResult RefineByIcp(const TriangleMesh& model, const TriangleMesh& truth,
                      const Sim3d& truth_from_model_start, const IcpOptions& options,
                      const JobControl& job) {
  ThrowIfInvalid(options.Check());
  const Icp icp(model, truth, truth_from_model_start, options);
  IcpResult result;
  Sim3d current = truth_from_model_start;
  std::vector<Correspondence> all = icp.start(), matches = icp.Trimmed(all);
  result.start_rms_m = WeightedRms(matches, std::numeric_limits<double>::infinity());
  double scale = std::min(kScaleOfRms * result.start_rms_m, icp.LargestScale());
  while (result.iterations < options.max_iterations && !result.converged && !matches.empty()) {
    job.ThrowIfCancelled();
    const IcpStep step = icp.Step(matches, scale);
    current = step.new_from_old * current;
    current.rotation.normalize();
    ++result.iterations;
    all = icp.MatchAll(current);
    matches = icp.Trimmed(all);
    scale = std::max(kScaleShrinkage * scale, kScaleOfRms * WeightedRms(matches, scale));
    result.converged = step.moved_m < 1e-9 * icp.size_m();
    job.Progress("icp", static_cast<std::size_t>(result.iterations),
                 static_cast<std::size_t>(options.max_iterations));
  }
  const bool is_worse = icp.LimitedRms(all, scale) > icp.LimitedRms(icp.start(), scale);
  result.truth_from_model = is_worse ? truth_from_model_start : current;
  result.rms_m =
      is_worse ? result.start_rms_m : WeightedRms(matches, std::numeric_limits<double>::infinity());
  return result;
}

TriangleMesh TransformMesh(const Sim3d& b_from_a, const TriangleMesh& mesh_in_a) {
  TriangleMesh mesh_in_b = mesh_in_a;
  for (Eigen::Vector3d& vertex : mesh_in_b.vertices) vertex = b_from_a * vertex;
  return mesh_in_b;
}

}  // namespace colmap_ext
