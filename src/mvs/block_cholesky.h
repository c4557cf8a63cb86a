// Cholesky factorisation of sparse symmetric positive definite matrices made of 3 x 3 blocks.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// Approximate minimum degree order of a graph: order[position] = node. `adjacency[i]`: the nodes
// next to i, without i, in both directions.
std::vector<int> MinimumDegreeOrder(const std::vector<std::vector<int>>& adjacency);

// The lower triangle of a block matrix, column by column: blocks of column p, the diagonal one
// excluded, are entries begin[p] … begin[p + 1] - 1, rows ascending.
struct BlockColumns {
  std::vector<int> begin{0};
  std::vector<int> row;
  std::vector<Eigen::Matrix3d> block;     // entry's value, rows of `row`, columns of p
  std::vector<Eigen::Matrix3d> diagonal;  // of each column; symmetric, both halves filled

  int size() const { return static_cast<int>(diagonal.size()); }
};

// L Lᵀ = matrix, left-looking, no pivoting; the order of elimination is that of the columns.
class BlockCholesky {
 public:
  // Finds where L has blocks; the values of `matrix` do not matter.
  explicit BlockCholesky(const BlockColumns& matrix);

  // Computes L for a matrix with the same structure, any number of times. False: it is not positive
  // definite.
  bool Factor(const BlockColumns& matrix);
  // Solves L Lᵀ x = b in place; 3 numbers a block, in the order of the columns. Needs a factor.
  void Solve(std::vector<Eigen::Vector3d>* x) const;

 private:
  // A block column by column, each padded to four numbers.
  struct PaddedBlock {
    double value[12];
  };
  void EliminateWith(std::size_t column, int at, Eigen::Matrix3d* diagonal);
  bool FinishColumn(std::size_t p, const Eigen::Matrix3d& diagonal);

  std::vector<int> begin_;  // as in BlockColumns, of L
  std::vector<int> row_;
  std::vector<PaddedBlock> block_;         // of L below the diagonal
  std::vector<Eigen::Matrix3d> diagonal_;  // lower triangular, of L
  std::vector<int> place_;                 // of each row in the column at work
};

}  // namespace colmap_ext
