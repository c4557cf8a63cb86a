// The linear system of one view: three unknowns a triangle, coupled across shared edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/scene/view_mesh.h"
#include "mvs/block_cholesky.h"

namespace colmap_ext {

// Two triangles that share an edge. Corners are numbered inside each triangle.
struct FacetEdge {
  int triangle[2];
  int opposite[2];   // the corner that is not on the edge
  int shared[2][2];  // shared[side][v]: corner of triangle[side] at the edge's vertex v
  Eigen::Vector3d
      beta[2];  // barycentric coordinates of the other's opposite corner in triangle[side]
  double color_weight = 1;  // w_c
};

std::vector<FacetEdge> CollectEdges(const ImageMesh& mesh, const SuperpixelStereoOptions& options);

// The terms of a view's energy that do not depend on observations, λ_s E_smooth + λ_c E_continuity
// (paper's equations), as a quadratic form dᵀ H d in the inverse depths of all triangles, stored as
// 3 x 3 blocks: one a triangle and one an edge. E_smooth's rows are divided by their norm
// (1 + |β|²)^½, so that a thin triangle's extrapolation does not outweigh the rest. Immutable.
class FacetSystem {
 public:
  FacetSystem(std::size_t num_triangles, const std::vector<FacetEdge>& edges,
              double smoothness_weight, double continuity_weight);

  std::size_t num_triangles() const { return diagonal_.size(); }

 private:
  friend class FacetSolver;
  struct Link {  // of a triangle to an adjacent one
    int other;
    int edge;
    bool first;  // this triangle is the edge's first
  };

  Eigen::Matrix3d Coupling(const Link& link) const {  // rows of this triangle, columns of the other
    const Eigen::Matrix3d& block = edge_blocks_[static_cast<std::size_t>(link.edge)];
    return link.first ? block : Eigen::Matrix3d(block.transpose());
  }

  std::vector<Eigen::Matrix3d> diagonal_;
  std::vector<Eigen::Matrix3d> edge_blocks_;
  std::vector<std::array<Link, 3>> links_;  // other == -1: no triangle there
  std::vector<int> order_;                  // of elimination: position to triangle
};

// Minimises stiffness · dᵀ H d + Σ weight (inverse_depth - barycentric · d)² over some of the
// triangles. What depends on the choice of these alone is found once, at construction.
class FacetSolver {
 public:
  // The triangles with fixed[t] != 0 keep their inverse depth; `fixed` may be empty: none. `system`
  // must outlive this object.
  FacetSolver(const FacetSystem& system, const std::vector<std::uint8_t>& fixed);

  // Rows of fixed triangles do nothing. Where no row decides, a proximal term of weight 1e-12 keeps
  // the given value, which is how the system stays regular; repeated solves lose its trace. False
  // when the factorisation fails.
  bool Solve(double stiffness, const std::vector<DepthRow>& rows,
             std::vector<Eigen::Vector3d>* inverse_depth);

 private:
  std::vector<Eigen::Vector3d> RightSide(double stiffness, const std::vector<DepthRow>& rows,
                                         const std::vector<Eigen::Vector3d>& inverse_depth);

  const FacetSystem& system_;
  std::vector<int> triangle_at_;  // position in the order of elimination to triangle
  std::vector<int> position_of_;  // triangle to position; -1: fixed
  std::vector<FacetSystem::Link> link_of_entry_;  // of matrix_, seen from the column's triangle
  BlockColumns matrix_;
  std::optional<BlockCholesky> factor_;
};

}  // namespace colmap_ext
