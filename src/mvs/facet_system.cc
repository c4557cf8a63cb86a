#include "mvs/facet_system.h"

#include <algorithm>
#include <cmath>

#include "mvs/raster.h"

namespace colmap_ext {
namespace {

constexpr double kProximalWeight = 1e-12;

const Eigen::Vector2d& Corner(const ImageMesh& mesh, int triangle, int k) {
  return mesh
      .vertices_px[static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(triangle)][k])];
}

FacetEdge MakeEdge(const ImageMesh& mesh, int t, int k, int other,
                   const SuperpixelStereoOptions& options) {
  FacetEdge edge;
  const Eigen::Vector3i& back = mesh.neighbors[static_cast<std::size_t>(other)];
  int k_other = 0;
  while (back[k_other] != t) ++k_other;
  edge.triangle[0] = t;
  edge.triangle[1] = other;
  edge.opposite[0] = k;
  edge.opposite[1] = k_other;
  // Both triangles turn the same way, so they run along the edge in opposite directions.
  edge.shared[0][0] = (k + 1) % 3;
  edge.shared[0][1] = (k + 2) % 3;
  edge.shared[1][0] = (k_other + 2) % 3;
  edge.shared[1][1] = (k_other + 1) % 3;
  for (int side = 0; side < 2; ++side) {
    edge.beta[side] =
        Barycentric(Corner(mesh, edge.triangle[side], 0), Corner(mesh, edge.triangle[side], 1),
                    Corner(mesh, edge.triangle[side], 2),
                    Corner(mesh, edge.triangle[1 - side], edge.opposite[1 - side]));
  }
  const double difference =
      (mesh.mean_bgr[static_cast<std::size_t>(t)] - mesh.mean_bgr[static_cast<std::size_t>(other)])
          .norm() /
      std::sqrt(3.0);
  const double ratio = difference / options.color_sigma;
  edge.color_weight = std::max(options.min_color_weight, std::exp(-0.5 * ratio * ratio));
  return edge;
}

}  // namespace

std::vector<FacetEdge> CollectEdges(const ImageMesh& mesh, const SuperpixelStereoOptions& options) {
  std::vector<FacetEdge> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int other = mesh.neighbors[t][k];
      if (other > static_cast<int>(t)) {
        edges.push_back(MakeEdge(mesh, static_cast<int>(t), k, other, options));
      }
    }
  }
  return edges;
}

FacetSystem::FacetSystem(std::size_t num_triangles, const std::vector<FacetEdge>& edges,
                         double smoothness_weight, double continuity_weight)
    : diagonal_(num_triangles, Eigen::Matrix3d::Zero()),
      edge_blocks_(edges.size(), Eigen::Matrix3d::Zero()),
      links_(num_triangles, {Link{-1, 0, false}, Link{-1, 0, false}, Link{-1, 0, false}}) {
  std::vector<std::vector<int>> adjacency(num_triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const FacetEdge& edge = edges[e];
    Eigen::Matrix3d* diagonal[2];
    for (int side = 0; side < 2; ++side) {
      const auto t = static_cast<std::size_t>(edge.triangle[side]);
      diagonal[side] = &diagonal_[t];
      links_[t].at(adjacency[t].size()) = {edge.triangle[1 - side], static_cast<int>(e), side == 0};
      adjacency[t].push_back(edge.triangle[1 - side]);
    }
    Eigen::Matrix3d& coupling = edge_blocks_[e];
    const double continuity = continuity_weight * edge.color_weight;
    for (int v = 0; v < 2; ++v) {
      const int a = edge.shared[0][v];
      const int b = edge.shared[1][v];
      (*diagonal[0])(a, a) += continuity;
      (*diagonal[1])(b, b) += continuity;
      coupling(a, b) -= continuity;
    }
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d& beta = edge.beta[side];
      const int apex = edge.opposite[1 - side];
      const double smoothness = smoothness_weight * edge.color_weight / (1.0 + beta.squaredNorm());
      *diagonal[side] += smoothness * beta * beta.transpose();
      (*diagonal[1 - side])(apex, apex) += smoothness;
      if (side == 0) {
        coupling.col(apex) -= smoothness * beta;
      } else {
        coupling.row(apex) -= smoothness * beta.transpose();
      }
    }
  }
  order_ = MinimumDegreeOrder(adjacency);
}

FacetSolver::FacetSolver(const FacetSystem& system, const std::vector<std::uint8_t>& fixed)
    : system_(system), position_of_(system.num_triangles(), -1) {
  for (const int t : system.order_) {
    if (!fixed.empty() && fixed[static_cast<std::size_t>(t)] != 0) continue;
    position_of_[static_cast<std::size_t>(t)] = static_cast<int>(triangle_at_.size());
    triangle_at_.push_back(t);
  }
  std::vector<std::pair<int, FacetSystem::Link>> below;
  for (std::size_t p = 0; p < triangle_at_.size(); ++p) {
    below.clear();
    for (const FacetSystem::Link& link : system.links_[static_cast<std::size_t>(triangle_at_[p])]) {
      const int row = link.other < 0 ? -1 : position_of_[static_cast<std::size_t>(link.other)];
      if (row > static_cast<int>(p)) below.emplace_back(row, link);
    }
    std::sort(below.begin(), below.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [row, link] : below) {
      matrix_.row.push_back(row);
      link_of_entry_.push_back(link);
    }
    matrix_.begin.push_back(static_cast<int>(matrix_.row.size()));
  }
  matrix_.block.resize(matrix_.row.size());
  matrix_.diagonal.resize(triangle_at_.size());
  factor_.emplace(matrix_);
}

// Fills the matrix as well; what the fixed triangles say goes to the right-hand side.
std::vector<Eigen::Vector3d> FacetSolver::RightSide(
    double stiffness, const std::vector<DepthRow>& rows,
    const std::vector<Eigen::Vector3d>& inverse_depth) {
  std::vector<Eigen::Vector3d> right_side(triangle_at_.size());
  for (std::size_t p = 0; p < triangle_at_.size(); ++p) {
    const auto t = static_cast<std::size_t>(triangle_at_[p]);
    matrix_.diagonal[p] =
        stiffness * system_.diagonal_[t] + kProximalWeight * Eigen::Matrix3d::Identity();
    right_side[p] = kProximalWeight * inverse_depth[t];
    for (const FacetSystem::Link& link : system_.links_[t]) {
      if (link.other < 0 || position_of_[static_cast<std::size_t>(link.other)] >= 0) continue;
      right_side[p] -=
          stiffness * system_.Coupling(link) * inverse_depth[static_cast<std::size_t>(link.other)];
    }
    for (int e = matrix_.begin[p]; e < matrix_.begin[p + 1]; ++e) {
      const auto entry = static_cast<std::size_t>(e);
      matrix_.block[entry] = stiffness * system_.Coupling(link_of_entry_[entry]).transpose();
    }
  }
  for (const DepthRow& row : rows) {
    const int position = position_of_[static_cast<std::size_t>(row.triangle)];
    if (position < 0) continue;
    const auto p = static_cast<std::size_t>(position);
    matrix_.diagonal[p] += row.weight * row.barycentric * row.barycentric.transpose();
    right_side[p] += row.weight * row.inverse_depth * row.barycentric;
  }
  return right_side;
}

bool FacetSolver::Solve(double stiffness, const std::vector<DepthRow>& rows,
                        std::vector<Eigen::Vector3d>* inverse_depth) {
  std::vector<Eigen::Vector3d> x = RightSide(stiffness, rows, *inverse_depth);
  if (!factor_->Factor(matrix_)) return false;
  factor_->Solve(&x);
  for (std::size_t p = 0; p < x.size(); ++p) {
    (*inverse_depth)[static_cast<std::size_t>(triangle_at_[p])] = x[p];
  }
  return true;
}

}  // namespace colmap_ext
