#include "mvs/facet_system.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "mvs/raster.h"

namespace colmap_ext {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

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

// Fill-reducing order of the free triangles: approximate minimum degree on their graph, whose nodes
// stand for 3 x 3 blocks. order[position] = triangle (as numbered in `adjacency`).
std::vector<int> MinimumDegreeOrder(const std::vector<std::vector<int>>& adjacency) {
  const int n = static_cast<int>(adjacency.size());
  Eigen::SparseMatrix<float> graph(n, n);
  Eigen::VectorXi sizes(n);
  for (int i = 0; i < n; ++i) {
    sizes[i] = static_cast<int>(adjacency[static_cast<std::size_t>(i)].size()) + 1;
  }
  graph.reserve(sizes);
  for (int i = 0; i < n; ++i) {
    graph.insert(i, i) = 1.0F;
    for (const int j : adjacency[static_cast<std::size_t>(i)]) graph.insert(j, i) = 1.0F;
  }
  graph.makeCompressed();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  std::vector<int> order(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) order[static_cast<std::size_t>(i)] = permutation.indices()[i];
  return order;
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
    : diagonal_(num_triangles),
      edge_blocks_(edges.size(), Eigen::Matrix3d::Zero()),
      right_side_(num_triangles),
      links_(num_triangles) {
  for (std::size_t t = 0; t < num_triangles; ++t) {
    diagonal_[t] = kProximalWeight * Eigen::Matrix3d::Identity();
    right_side_[t].setZero();
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const FacetEdge& edge = edges[e];
    Eigen::Matrix3d* diagonal[2];
    for (int side = 0; side < 2; ++side) {
      const auto t = static_cast<std::size_t>(edge.triangle[side]);
      diagonal[side] = &diagonal_[t];
      links_[t].push_back({edge.triangle[1 - side], static_cast<int>(e), side == 0});
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
}

void FacetSystem::Add(const DepthRow& row) {
  const auto t = static_cast<std::size_t>(row.triangle);
  diagonal_[t] += row.weight * row.barycentric * row.barycentric.transpose();
  right_side_[t] += row.weight * row.inverse_depth * row.barycentric;
}

// The free triangles in the order of elimination.
struct FacetSystem::Elimination {
  std::vector<int> triangle_at;  // position to triangle
  std::vector<int> position_of;  // triangle to position; -1: fixed
};

FacetSystem::Elimination FacetSystem::PlanElimination(
    const std::vector<std::uint8_t>& fixed) const {
  const std::size_t num_triangles = diagonal_.size();
  std::vector<int> free_index(num_triangles, -1);
  std::vector<int> free_triangles;
  for (std::size_t t = 0; t < num_triangles; ++t) {
    if (!fixed.empty() && fixed[t] != 0) continue;
    free_index[t] = static_cast<int>(free_triangles.size());
    free_triangles.push_back(static_cast<int>(t));
  }
  std::vector<std::vector<int>> adjacency(free_triangles.size());
  for (std::size_t i = 0; i < free_triangles.size(); ++i) {
    for (const Link& link : links_[static_cast<std::size_t>(free_triangles[i])]) {
      const int j = free_index[static_cast<std::size_t>(link.other)];
      if (j >= 0) adjacency[i].push_back(j);
    }
  }
  Elimination plan;
  plan.position_of.assign(num_triangles, -1);
  if (free_triangles.empty()) return plan;
  for (const int i : MinimumDegreeOrder(adjacency)) {
    const int t = free_triangles[static_cast<std::size_t>(i)];
    plan.position_of[static_cast<std::size_t>(t)] = static_cast<int>(plan.triangle_at.size());
    plan.triangle_at.push_back(t);
  }
  return plan;
}

// The upper triangle of the reduced matrix in compressed columns, and its right-hand side.
struct FacetSystem::Reduced {
  std::vector<int> outer{0};
  std::vector<int> inner;
  std::vector<double> values;
  Eigen::VectorXd right_side;
};

// Written column by column straight into place; fixed triangles go to the right-hand side.
FacetSystem::Reduced FacetSystem::Assemble(const Elimination& plan,
                                           const std::vector<Eigen::Vector3d>& depth) const {
  const std::size_t count = plan.triangle_at.size();
  const auto position = [&](const Link& link) {
    return plan.position_of[static_cast<std::size_t>(link.other)];
  };
  Reduced reduced;
  reduced.right_side.resize(3 * static_cast<Eigen::Index>(count));
  reduced.outer.reserve(3 * count + 1);
  reduced.inner.reserve(24 * count);
  reduced.values.reserve(24 * count);
  std::vector<Link> above;
  for (std::size_t p = 0; p < count; ++p) {
    const auto t = static_cast<std::size_t>(plan.triangle_at[p]);
    Eigen::Vector3d g = right_side_[t] + kProximalWeight * depth[t];
    above.clear();
    for (const Link& link : links_[t]) {
      if (position(link) < 0) {
        g -= Coupling(link) * depth[static_cast<std::size_t>(link.other)];
      } else if (position(link) < static_cast<int>(p)) {
        above.push_back(link);
      }
    }
    std::sort(above.begin(), above.end(),
              [&](const Link& a, const Link& b) { return position(a) < position(b); });
    reduced.right_side.segment<3>(3 * static_cast<Eigen::Index>(p)) = g;
    for (int c = 0; c < 3; ++c) {
      for (const Link& link : above) {
        const Eigen::Matrix3d block = Coupling(link);  // rows of t, columns of the other
        for (int r = 0; r < 3; ++r) {
          reduced.inner.push_back(3 * position(link) + r);
          reduced.values.push_back(block(c, r));
        }
      }
      for (int r = 0; r <= c; ++r) {
        reduced.inner.push_back(3 * static_cast<int>(p) + r);
        reduced.values.push_back(diagonal_[t](r, c));
      }
      reduced.outer.push_back(static_cast<int>(reduced.inner.size()));
    }
  }
  return reduced;
}

bool FacetSystem::Solve(const std::vector<std::uint8_t>& fixed,
                        std::vector<Eigen::Vector3d>* inverse_depth) const {
  const Elimination plan = PlanElimination(fixed);
  if (plan.triangle_at.empty()) return true;
  const Reduced reduced = Assemble(plan, *inverse_depth);
  const Eigen::Index size = reduced.right_side.size();
  const Eigen::Map<const SparseMatrix> matrix(
      size, size, static_cast<Eigen::Index>(reduced.inner.size()), reduced.outer.data(),
      reduced.inner.data(), reduced.values.data());
  const Eigen::SimplicialLLT<SparseMatrix, Eigen::Upper, Eigen::NaturalOrdering<int>> factor(
      matrix);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::VectorXd solution = factor.solve(reduced.right_side);
  for (std::size_t p = 0; p < plan.triangle_at.size(); ++p) {
    (*inverse_depth)[static_cast<std::size_t>(plan.triangle_at[p])] =
        solution.segment<3>(3 * static_cast<Eigen::Index>(p));
  }
  return true;
}

}  // namespace colmap_ext
