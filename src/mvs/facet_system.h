// The linear system of one view: three unknowns a triangle, coupled across shared edges.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/scene/view_mesh.h"

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

// Quadratic form dᵀ H d - 2 gᵀ d over all triangles' inverse depths, stored as 3 x 3 blocks: one a
// triangle and one an edge.
class FacetSystem {
 public:
  // λ_s E_smooth + λ_c E_continuity (paper's equations). E_smooth's rows are divided by their norm,
  // so that a thin triangle's extrapolation does not outweigh the rest.
  FacetSystem(std::size_t num_triangles, const std::vector<FacetEdge>& edges,
              double smoothness_weight, double continuity_weight);

  // + weight (inverse_depth - barycentric · d)²: E_sfm and E_fusion alike.
  void Add(const DepthRow& row);

  // Minimises the form over the triangles with fixed[t] == 0; the others keep their value in
  // `inverse_depth`. `fixed` may be empty: none. Where no row decides, a proximal term of weight
  // 1e-12 keeps the given value, which is how the system stays regular; repeated solves lose its
  // trace. False when the factorisation fails.
  bool Solve(const std::vector<std::uint8_t>& fixed,
             std::vector<Eigen::Vector3d>* inverse_depth) const;

 private:
  struct Link {  // of a triangle to an adjacent one
    int other;
    int edge;
    bool first;  // this triangle is the edge's first
  };

  struct Elimination;
  struct Reduced;
  Elimination PlanElimination(const std::vector<std::uint8_t>& fixed) const;
  Reduced Assemble(const Elimination& plan, const std::vector<Eigen::Vector3d>& depth) const;

  Eigen::Matrix3d Coupling(const Link& link) const {  // rows of this triangle, columns of the other
    const Eigen::Matrix3d& block = edge_blocks_[static_cast<std::size_t>(link.edge)];
    return link.first ? block : Eigen::Matrix3d(block.transpose());
  }

  std::vector<Eigen::Matrix3d> diagonal_;
  std::vector<Eigen::Matrix3d> edge_blocks_;
  std::vector<Eigen::Vector3d> right_side_;
  std::vector<std::vector<Link>> links_;
};

}  // namespace colmap_ext
