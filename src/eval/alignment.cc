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

// A truth sample and the nearest model point, both in the truth frame.
struct Correspondence {
  Eigen::Vector3d model_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d truth_point = Eigen::Vector3d::Zero();
  Eigen::Vector3d truth_normal = Eigen::Vector3d::Zero();
  double distance = std::numeric_limits<double>::infinity();
};

struct IcpStep {
  Sim3d new_from_old;
  double moved_m = 0;
};

class Icp {
 public:
  Icp(const TriangleMesh& model, const TriangleMesh& truth, const IcpOptions& options)
      : options_(options),
        samples_(
            SamplesWithNormals(truth, static_cast<std::size_t>(options.num_samples), options.seed)),
        finder_(model, false) {
    if (model.vertices.empty()) throw Error("ICP: the model is empty");
    if (samples_.empty()) throw Error("ICP: the ground truth has no surface");
    size_m_ = BoundsOf(truth).diagonal().norm();
  }

  double size_m() const { return size_m_; }

  // The correspondences that survive the distance limit and the trim. Their choice and order are
  // the same whatever the number of threads.
  std::vector<Correspondence> Match(const Sim3d& truth_from_model) const {
    const Sim3d model_from_truth = Inverse(truth_from_model);
    const double max_in_model = options_.max_distance_m * model_from_truth.scale;
    std::vector<Correspondence> all(samples_.size());
    ParallelFor(samples_.size(), [&](std::size_t i) {
      const SurfaceSample& sample = samples_[i];
      const auto found = finder_.Find(model_from_truth * sample.position, max_in_model);
      if (!found) return;
      all[i] = {truth_from_model * found->position, sample.position, sample.normal,
                found->distance * truth_from_model.scale};
    });
    std::vector<double> distances;
    for (const Correspondence& c : all) {
      if (std::isfinite(c.distance)) distances.push_back(c.distance);
    }
    if (distances.empty()) {
      throw Error("ICP: the model lies nowhere within " + std::to_string(options_.max_distance_m) +
                  " m of the ground truth; check that both are in one frame, or give the cameras "
                  "of both (--input_path, --camera_path)");
    }
    const auto keep = static_cast<std::size_t>(
        std::ceil((1.0 - options_.trim) * static_cast<double>(samples_.size())));
    if (distances.size() > keep) {
      const auto cut = distances.begin() + static_cast<std::ptrdiff_t>(keep - 1);
      std::nth_element(distances.begin(), cut, distances.end());
      const double limit = *cut;
      std::erase_if(all, [&](const Correspondence& c) { return c.distance > limit; });
    } else {
      std::erase_if(all, [](const Correspondence& c) { return !std::isfinite(c.distance); });
    }
    return all;
  }

  // Trimmed RMS where correspondences that were not found count with the distance limit, so that a
  // transform cannot look better by losing samples.
  double TrimmedRms(const std::vector<Correspondence>& matches) const {
    const double wanted = std::ceil((1.0 - options_.trim) * static_cast<double>(samples_.size()));
    double sum = 0;
    for (const Correspondence& c : matches) sum += c.distance * c.distance;
    const double missing = std::max(0.0, wanted - static_cast<double>(matches.size()));
    sum += missing * options_.max_distance_m * options_.max_distance_m;
    return std::sqrt(sum / (missing + static_cast<double>(matches.size())));
  }

  // One Gauss-Newton step on Σ (nᵀ(T p - q))² over rotation, log scale and translation about the
  // centre of the matches, all in metres at their RMS radius.
  IcpStep Step(const std::vector<Correspondence>& matches) const {
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
      hessian += row * row.transpose();
      gradient += row * c.truth_normal.dot(c.model_point - c.truth_point);
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
  double size_m_ = 0;  // diagonal of the truth
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
  if (num_samples < 100 || num_samples > 10000000) return "icp_samples must be 100 … 10000000";
  return "";
}

IcpResult RefineByIcp(const TriangleMesh& model, const TriangleMesh& truth,
                      const Sim3d& truth_from_model_start, const IcpOptions& options,
                      const JobControl& job) {
  ThrowIfInvalid(options.Check());
  const Icp icp(model, truth, options);
  IcpResult result;
  result.truth_from_model = truth_from_model_start;
  Sim3d current = truth_from_model_start;
  std::vector<Correspondence> matches = icp.Match(current);
  result.start_rms_m = result.rms_m = icp.TrimmedRms(matches);
  while (result.iterations < options.max_iterations && !result.converged) {
    job.ThrowIfCancelled();
    const IcpStep step = icp.Step(matches);
    current = step.new_from_old * current;
    current.rotation.normalize();
    ++result.iterations;
    matches = icp.Match(current);
    const double rms_m = icp.TrimmedRms(matches);
    if (rms_m <= result.rms_m) {
      result.rms_m = rms_m;
      result.truth_from_model = current;
    }
    result.converged = step.moved_m < 1e-9 * icp.size_m();
    job.Progress("icp", static_cast<std::size_t>(result.iterations),
                 static_cast<std::size_t>(options.max_iterations));
  }
  return result;
}

TriangleMesh TransformMesh(const Sim3d& b_from_a, const TriangleMesh& mesh_in_a) {
  TriangleMesh mesh_in_b = mesh_in_a;
  for (Eigen::Vector3d& vertex : mesh_in_b.vertices) vertex = b_from_a * vertex;
  return mesh_in_b;
}

}  // namespace colmap_ext
