#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "colmap_ext/util/job_control.h"
#include "path/leg_planner.h"

namespace colmap_ext {

using Polyline = std::vector<Eigen::Vector3d>;

double LengthOf(const Polyline& polyline);

// Proved ways between places, of which the first (node 0) must reach all others.
class LegTable {
 public:
  // Finds the legs from node 0; `planner` must outlive this.
  LegTable(const LegPlanner& planner, Polyline places, const JobControl& job);

  // Whether a way from node 0 was found.
  bool IsReached(std::size_t node) const { return node == 0 || !Direct(0, node).empty(); }

  // Takes out the nodes that are not reached and finds ways between all others: direct legs between
  // all of them, or, when they are many, from each to its nearest ones; the rest is joined by way
  // of other nodes where that is the shortest. Throws CancelledError.
  void FindAll(const JobControl& job);

  const Polyline& places() const { return places_; }
  // n x n, metres; after FindAll.
  const Eigen::MatrixXd& lengths() const { return length_m_; }
  // Corners of the way, both ends included; after FindAll.
  Polyline Leg(std::size_t from, std::size_t to) const;

 private:
  const Polyline& Direct(std::size_t from, std::size_t to) const {
    return direct_[from * places_.size() + to];
  }
  void FindDirect(std::size_t from, std::size_t to);
  void KeepReached();
  std::vector<std::pair<std::size_t, std::size_t>> PairsToFind() const;
  void JoinShortest();

  const LegPlanner& planner_;
  Polyline places_;
  std::vector<Polyline> direct_;  // n x n; empty: none
  Eigen::MatrixXd length_m_;
  Eigen::MatrixXi first_stop_;  // n x n: where the way from row to column goes first
};

}  // namespace colmap_ext
