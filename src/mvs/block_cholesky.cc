#include "mvs/block_cholesky.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <cmath>
#include <cstring>

#include "mvs/simd_lanes.h"

namespace colmap_ext {
namespace {

constexpr int kBlockNumbers = 12;  // a block's columns are padded to four numbers

// For each of `count` blocks l of `column`, with rows `row`: blocks[place[row]] -= l bᵀ.
inline __attribute__((always_inline)) void SubtractBody(const double* column, const int* row,
                                                        int count, const int* place,
                                                        const double* b, double* blocks) {
  for (int e = 0; e < count; ++e) {
    const double* l = column + static_cast<std::ptrdiff_t>(e) * kBlockNumbers;
    double* target = blocks + static_cast<std::ptrdiff_t>(place[row[e]]) * kBlockNumbers;
    const DoubleLanes l0 = *reinterpret_cast<const DoubleLanesAt*>(l);
    const DoubleLanes l1 = *reinterpret_cast<const DoubleLanesAt*>(l + 4);
    const DoubleLanes l2 = *reinterpret_cast<const DoubleLanesAt*>(l + 8);
    for (int c = 0; c < 3; ++c) {
      auto& sum = *reinterpret_cast<DoubleLanesAt*>(target + 4 * c);
      sum -= l0 * b[c] + l1 * b[4 + c] + l2 * b[8 + c];
    }
  }
}
void SubtractPlainly(const double* column, const int* row, int count, const int* place,
                     const double* b, double* blocks) {
  SubtractBody(column, row, count, place, b, blocks);
}
COLMAP_EXT_TARGET_AVX2 void SubtractWithAvx2(const double* column, const int* row, int count,
                                             const int* place, const double* b, double* blocks) {
  SubtractBody(column, row, count, place, b, blocks);
}

// Parents in the elimination tree (Liu 1990); -1 for roots. `earlier[i]`: columns p < i with a
// block in row i.
std::vector<int> EliminationTree(const std::vector<std::vector<int>>& earlier) {
  std::vector<int> parent(earlier.size(), -1);
  std::vector<int> ancestor(earlier.size(), -1);
  for (int i = 0; i < static_cast<int>(earlier.size()); ++i) {
    for (int p : earlier[static_cast<std::size_t>(i)]) {
      while (p != -1 && p < i) {
        const int next = ancestor[static_cast<std::size_t>(p)];
        ancestor[static_cast<std::size_t>(p)] = i;
        if (next == -1) parent[static_cast<std::size_t>(p)] = i;
        p = next;
      }
    }
  }
  return parent;
}

}  // namespace

std::vector<int> MinimumDegreeOrder(const std::vector<std::vector<int>>& adjacency) {
  const int n = static_cast<int>(adjacency.size());
  std::vector<int> order(adjacency.size());
  if (n == 0) return order;
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
  for (int i = 0; i < n; ++i) order[static_cast<std::size_t>(i)] = permutation.indices()[i];
  return order;
}

// Row i of L has blocks in the columns on the tree's paths from the columns of row i of the matrix
// up to i.
BlockCholesky::BlockCholesky(const BlockColumns& matrix) {
  const auto n = static_cast<std::size_t>(matrix.size());
  std::vector<std::vector<int>> earlier(n);
  for (std::size_t p = 0; p < n; ++p) {
    for (int e = matrix.begin[p]; e < matrix.begin[p + 1]; ++e) {
      earlier[static_cast<std::size_t>(matrix.row[static_cast<std::size_t>(e)])].push_back(
          static_cast<int>(p));
    }
  }
  const std::vector<int> parent = EliminationTree(earlier);
  std::vector<int> visited(n, -1);
  const auto for_each_entry = [&](const auto& visit) {
    std::fill(visited.begin(), visited.end(), -1);
    for (int i = 0; i < static_cast<int>(n); ++i) {
      visited[static_cast<std::size_t>(i)] = i;
      for (int p : earlier[static_cast<std::size_t>(i)]) {
        for (; visited[static_cast<std::size_t>(p)] != i; p = parent[static_cast<std::size_t>(p)]) {
          visited[static_cast<std::size_t>(p)] = i;
          visit(static_cast<std::size_t>(p), i);
        }
      }
    }
  };
  begin_.assign(n + 1, 0);
  for_each_entry([&](std::size_t p, int) { ++begin_[p + 1]; });
  for (std::size_t p = 0; p < n; ++p) begin_[p + 1] += begin_[p];
  row_.resize(static_cast<std::size_t>(begin_[n]));
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for_each_entry([&](std::size_t p, int i) { row_[static_cast<std::size_t>(next[p]++)] = i; });
}

// Takes column `column`, whose entry `at` is in row p, out of column p.
void BlockCholesky::EliminateWith(std::size_t column, int at, Eigen::Matrix3d* diagonal) {
  const double* b = block_[static_cast<std::size_t>(at)].value;  // L(p, column)
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      (*diagonal)(r, c) -= b[r] * b[c] + b[4 + r] * b[4 + c] + b[8 + r] * b[8 + c];
    }
  }
  const int count = begin_[column + 1] - at - 1;
  if (count == 0) return;
  const auto first = static_cast<std::size_t>(at) + 1;
  const auto subtract = HasAvx2() ? SubtractWithAvx2 : SubtractPlainly;
  subtract(block_[first].value, &row_[first], count, place_.data(), b, block_.front().value);
}

// Cholesky factor of the diagonal block, then L(i, p) = A(i, p) L(p, p)⁻ᵀ.
bool BlockCholesky::FinishColumn(std::size_t p, const Eigen::Matrix3d& diagonal) {
  Eigen::Matrix3d& l = diagonal_[p];
  l.setZero();
  for (int c = 0; c < 3; ++c) {
    for (int r = c; r < 3; ++r) {
      double value = diagonal(r, c);
      for (int m = 0; m < c; ++m) value -= l(r, m) * l(c, m);
      if (r == c && !(value > 0)) return false;
      l(r, c) = r == c ? std::sqrt(value) : value / l(c, c);
    }
  }
  const double i0 = 1.0 / l(0, 0), i1 = 1.0 / l(1, 1), i2 = 1.0 / l(2, 2);
  for (int e = begin_[p]; e < begin_[p + 1]; ++e) {
    double* x = block_[static_cast<std::size_t>(e)].value;
    for (int r = 0; r < 4; ++r) {
      const double x0 = x[r] * i0;
      const double x1 = (x[4 + r] - x0 * l(1, 0)) * i1;
      x[8 + r] = (x[8 + r] - x0 * l(2, 0) - x1 * l(2, 1)) * i2;
      x[r] = x0;
      x[4 + r] = x1;
    }
  }
  return true;
}

bool BlockCholesky::Factor(const BlockColumns& matrix) {
  const auto n = static_cast<std::size_t>(matrix.size());
  block_.assign(row_.size(), PaddedBlock{});
  diagonal_.resize(n);
  place_.resize(n);
  // Columns that are done wait in the list of the next row where they have a block.
  std::vector<int> first_of_row(n, -1), next(n), position(begin_.begin(), begin_.end() - 1);
  const auto enlist = [&](std::size_t k) {
    if (position[k] >= begin_[k + 1]) return;
    const int row = row_[static_cast<std::size_t>(position[k])];
    next[k] = first_of_row[static_cast<std::size_t>(row)];
    first_of_row[static_cast<std::size_t>(row)] = static_cast<int>(k);
  };
  for (std::size_t p = 0; p < n; ++p) {
    for (int e = begin_[p]; e < begin_[p + 1]; ++e) {
      place_[static_cast<std::size_t>(row_[static_cast<std::size_t>(e)])] = e;
    }
    for (int e = matrix.begin[p]; e < matrix.begin[p + 1]; ++e) {
      const auto entry = static_cast<std::size_t>(e);
      const auto target =
          static_cast<std::size_t>(place_[static_cast<std::size_t>(matrix.row[entry])]);
      Eigen::Map<Eigen::Matrix3d, 0, Eigen::OuterStride<4>>(block_[target].value) =
          matrix.block[entry];
    }
    Eigen::Matrix3d diagonal = matrix.diagonal[p];
    for (int k = first_of_row[p]; k != -1;) {
      const auto column = static_cast<std::size_t>(k);
      k = next[column];
      EliminateWith(column, position[column]++, &diagonal);
      enlist(column);
    }
    if (!FinishColumn(p, diagonal)) return false;
    enlist(p);
  }
  return true;
}

void BlockCholesky::Solve(std::vector<Eigen::Vector3d>* x) const {
  const std::size_t n = diagonal_.size();
  const auto block = [&](int e) {
    return Eigen::Map<const Eigen::Matrix3d, 0, Eigen::OuterStride<4>>(
        block_[static_cast<std::size_t>(e)].value);
  };
  const auto at = [&](int e) -> Eigen::Vector3d& {
    return (*x)[static_cast<std::size_t>(row_[static_cast<std::size_t>(e)])];
  };
  for (std::size_t p = 0; p < n; ++p) {
    Eigen::Vector3d& value = (*x)[p];
    diagonal_[p].triangularView<Eigen::Lower>().solveInPlace(value);
    for (int e = begin_[p]; e < begin_[p + 1]; ++e) at(e).noalias() -= block(e) * value;
  }
  for (std::size_t p = n; p-- > 0;) {
    Eigen::Vector3d& value = (*x)[p];
    for (int e = begin_[p]; e < begin_[p + 1]; ++e) {
      value.noalias() -= block(e).transpose() * at(e);
    }
    diagonal_[p].triangularView<Eigen::Lower>().transpose().solveInPlace(value);
  }
}

}  // namespace colmap_ext
