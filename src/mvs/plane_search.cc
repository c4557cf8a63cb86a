#include "mvs/plane_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMaxHypotheses = 8;  // of a superpixel
constexpr float kExplained = 0.85F;        // correlation above which no other plane is tried
constexpr float kHopeless = 0.2F;  // two neighbours that are so much worse decide against a plane
constexpr float kGain = 0.03F;     // by which another plane must be better
constexpr float kSameDisparityPx = 0.4F;      // planes nearer than this are one
constexpr double kReferencePrecision = 3e-3;  // of relative depth: of a row of weight 1

}  // namespace

PatchScore ScorePlane(const PhotoPatch& patch, const PatchPlane& plane,
                      const std::vector<PixelTransfer>& transfers, float hopeless) {
  PatchScore score;
  score.correlation.fill(kUnseen);
  std::array<float, PatchScore::kMaxNeighbors> seen;
  const std::size_t num_neighbors =
      std::min<std::size_t>(transfers.size(), PatchScore::kMaxNeighbors);
  for (std::size_t j = 0; j < num_neighbors; ++j) {
    const float value = CompareInNeighbor(patch, plane, transfers[j]);
    score.correlation[j] = value;
    if (value == kUnseen) continue;
    seen[static_cast<std::size_t>(score.witnesses++)] = value;
    if (score.witnesses == 2 && std::max(seen[0], seen[1]) < hopeless) {
      score.best = std::max(seen[0], seen[1]);
      return score;
    }
  }
  if (score.witnesses == 0) return score;
  const int count = std::min(3, (score.witnesses + 1) / 2);
  std::partial_sort(seen.begin(), seen.begin() + count, seen.begin() + score.witnesses,
                    std::greater<>());
  score.best = 0;
  for (int k = 0; k < count; ++k) score.best += seen[static_cast<std::size_t>(k)];
  score.best /= static_cast<float>(count);
  return score;
}

PlaneSearch::PlaneSearch(const ViewMesh& mesh, const ViewLookup& lookup, const cv::Mat1i& grey,
                         std::vector<PixelTransfer> transfers,
                         const SuperpixelStereoOptions& options)
    : mesh_(mesh),
      lookup_(lookup),
      grey_(grey),
      transfers_(std::move(transfers)),
      options_(options),
      patches_(lookup.plane_in_cam.size()),
      has_patch_(lookup.plane_in_cam.size(), 0),
      planes_(lookup.plane_in_cam),
      scores_(lookup.plane_in_cam.size()),
      hypotheses_(static_cast<std::size_t>(mesh.image.num_superpixels)) {
  if (transfers_.size() > PatchScore::kMaxNeighbors) {
    transfers_.erase(transfers_.begin() + PatchScore::kMaxNeighbors, transfers_.end());
  }
  std::vector<double> inverse_depths;
  for (std::size_t t = 0; t < planes_.size(); ++t) {
    if (mesh.supported[t] != 0) inverse_depths.push_back(mesh.inverse_depth[t].mean());
  }
  if (inverse_depths.empty()) return;
  median_inverse_depth_ = MiddleValue(std::move(inverse_depths));
}

void PlaneSearch::AddHypothesis(int superpixel, const Eigen::Vector3d& plane_in_cam) {
  std::vector<Eigen::Vector3d>& planes = hypotheses_[static_cast<std::size_t>(superpixel)];
  if (planes.size() < kMaxHypotheses) planes.push_back(plane_in_cam);
}

const PhotoPatch& PlaneSearch::patch(std::size_t t) {
  if (has_patch_[t] == 0) {
    patches_[t] =
        MakePatch(mesh_, lookup_.triangle_at, grey_, static_cast<int>(t), options_.color_sigma);
    has_patch_[t] = 1;
  }
  return patches_[t];
}

void PlaneSearch::ScorePresentPlanes() {
  for (std::size_t t = 0; t < planes_.size(); ++t) {
    if (mesh_.supported[t] == 0) continue;
    scores_[t] = ScorePlane(patch(t), ToPatchPlane(planes_[t], mesh_.camera, patch(t)), transfers_);
  }
}

bool PlaneSearch::IsNew(std::size_t t, const PatchPlane& plane,
                        const std::vector<PatchPlane>& tried) const {
  // Pixels that the patch moves in the first neighbour for a change of inverse depth.
  const Eigen::Vector3f& b = transfers_.front().shift;
  const float px =
      std::hypot(b.x() - patches_[t].center.x() * b.z(), b.y() - patches_[t].center.y() * b.z());
  return std::none_of(tried.begin(), tried.end(), [&](const PatchPlane& other) {
    return px * (plane - other).lpNorm<1>() < kSameDisparityPx;
  });
}

void PlaneSearch::TryAround(std::size_t t, bool with_superpixel) {
  const PhotoPatch& patch = this->patch(t);
  std::vector<PatchPlane> tried{ToPatchPlane(planes_[t], mesh_.camera, patch)};
  PatchScore best = scores_[t];
  float wanted = best.best + kGain;
  bool found = false;
  Eigen::Vector3d best_plane = planes_[t];
  const auto attempt = [&](const Eigen::Vector3d& plane) {
    const PatchPlane on_patch = ToPatchPlane(plane, mesh_.camera, patch);
    if (!(on_patch[0] > 0) || !IsNew(t, on_patch, tried)) return;
    tried.push_back(on_patch);
    const PatchScore score = ScorePlane(patch, on_patch, transfers_, wanted - kHopeless);
    if (score.witnesses < 2 || score.best < wanted) return;
    wanted = score.best;
    best_plane = plane;
    found = true;
  };
  const auto has_plane = [&](int other) {
    return other >= 0 && scores_[static_cast<std::size_t>(other)].best > 0;
  };
  for (int k = 0; k < 3; ++k) {
    const int adjacent = mesh_.image.neighbors[t][k];
    if (adjacent < 0) continue;
    if (has_plane(adjacent)) attempt(planes_[static_cast<std::size_t>(adjacent)]);
    for (int m = 0; m < 3; ++m) {
      const int second = mesh_.image.neighbors[static_cast<std::size_t>(adjacent)][m];
      if (second != static_cast<int>(t) && has_plane(second)) {
        attempt(planes_[static_cast<std::size_t>(second)]);
      }
    }
  }
  if (with_superpixel) {
    for (const Eigen::Vector3d& plane :
         hypotheses_[static_cast<std::size_t>(mesh_.image.superpixel[t])]) {
      attempt(plane);
    }
  }
  if (!found) return;
  planes_[t] = best_plane;
  scores_[t] = ScorePlane(patch, ToPatchPlane(best_plane, mesh_.camera, patch), transfers_);
}

void PlaneSearch::TryHypotheses() {
  if (transfers_.empty()) return;
  const std::size_t count = planes_.size();
  for (std::size_t t = 0; t < count; ++t) {
    if (scores_[t].best < kExplained) TryAround(t, true);
  }
  for (std::size_t t = count; t-- > 0;) {
    if (scores_[t].best < kExplained) TryAround(t, false);
  }
}

// A plane after Gauss-Newton steps, and the normal equations there.
struct PlaneSearch::Refined {
  PatchPlane plane;
  Eigen::Matrix3f hessian = Eigen::Matrix3f::Zero();
  float correlation = kUnseen;  // 0 witnesses: kUnseen
};

PlaneSearch::Refined PlaneSearch::Refine(std::size_t t) {
  constexpr int kSteps = 2;
  constexpr float kMaxStep = 0.05F;  // of the inverse depth
  const PhotoPatch& patch = patches_[t];
  Refined best;
  PatchPlane plane = ToPatchPlane(planes_[t], mesh_.camera, patch);
  const auto least = static_cast<float>(
      std::max(options_.photometric_min_correlation, static_cast<double>(scores_[t].best) - 0.15));
  for (int step = 0; step <= kSteps; ++step) {
    Eigen::Matrix3f hessian = Eigen::Matrix3f::Zero();
    Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
    float sum = 0;
    int witnesses = 0;
    for (std::size_t j = 0; j < transfers_.size(); ++j) {
      if (scores_[t].correlation[j] < least) continue;
      const float value =
          AddNormalEquations(patch, plane, transfers_[j], 0.0F, &hessian, &gradient);
      if (value == kUnseen) continue;
      sum += value;
      ++witnesses;
    }
    if (witnesses == 0) break;
    const float correlation = sum / static_cast<float>(witnesses);
    if (correlation <= best.correlation) break;
    best = {plane, hessian, correlation};
    const float damping = 1e-3F * hessian(0, 0);
    hessian.diagonal().array() += damping;
    const Eigen::Vector3f change = hessian.ldlt().solve(-gradient);
    if (!(change.cwiseAbs().maxCoeff() < kMaxStep * plane[0])) break;
    plane += change;
  }
  return best;
}

void PlaneSearch::AppendRows(std::size_t t, const Refined& refined,
                             std::vector<DepthRow>* rows) const {
  constexpr double kMaxWeight = 20.0;  // of all rows of a facet
  const PhotoPatch& patch = patches_[t];
  const double radius = patch.radius;
  Eigen::Matrix3d corners_from_patch;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d offset =
        mesh_.image.vertices_px[static_cast<std::size_t>(mesh_.image.triangles[t][k])] -
        patch.center.cast<double>();
    corners_from_patch.row(k) << 1.0, offset.x() / radius, offset.y() / radius;
  }
  const Eigen::Matrix3d patch_from_corners = corners_from_patch.inverse();
  const Eigen::Vector3d corners = corners_from_patch * refined.plane.cast<double>();
  if (!(corners.minCoeff() > 0)) return;
  const double unit = median_inverse_depth_ * kReferencePrecision;
  Eigen::Matrix3d hessian = (unit * unit) * refined.hessian.cast<double>();
  const double strength = hessian(0, 0);
  if (!(strength > 1e-6)) return;
  const double factor = options_.photometric_weight * std::min(1.0, kMaxWeight / strength);
  hessian.diagonal().array() += 1e-6 * strength;
  const Eigen::LLT<Eigen::Matrix3d> cholesky(hessian);
  if (cholesky.info() != Eigen::Success) return;
  const Eigen::Matrix3d factor_rows =
      Eigen::Matrix3d(cholesky.matrixL()).transpose() * patch_from_corners;
  for (int r = 0; r < 3; ++r) {
    DepthRow row;
    row.triangle = static_cast<int>(t);
    row.barycentric = factor_rows.row(r);
    row.inverse_depth = row.barycentric.dot(corners);
    row.weight = factor;
    rows->push_back(row);
  }
}

std::vector<DepthRow> PlaneSearch::RefineAndCollectRows() {
  std::vector<DepthRow> rows;
  for (std::size_t t = 0; t < planes_.size(); ++t) {
    if (!(scores_[t].best >= static_cast<float>(options_.photometric_min_correlation))) continue;
    const Refined refined = Refine(t);
    if (refined.correlation != kUnseen) AppendRows(t, refined, &rows);
  }
  return rows;
}

}  // namespace colmap_ext
