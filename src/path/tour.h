#pragma once

#include <Eigen/Core>
#include <vector>

namespace colmap_ext {

// Order in which to visit nodes 1 … n - 1 from node 0 without coming back: nearest neighbour (the
// paper), then 2-opt and Or-opt (runs of up to 3 nodes) until nothing shortens it. `length`: n x n,
// symmetric, finite, >= 0. Returns the n nodes, 0 first. Ties go to the smaller index.
std::vector<int> ShortOpenTour(const Eigen::MatrixXd& length);

}  // namespace colmap_ext
