#include "path/leg_table.h"

#include <algorithm>
#include <limits>
#include <set>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

// Up to so many places, direct legs are looked for between all of them; beyond, from each to so
// many nearest ones.
constexpr std::size_t kFewPlaces = 48;
constexpr std::size_t kNearestPlaces = 14;

}  // namespace

double LengthOf(const Polyline& polyline) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    length += (polyline[i + 1] - polyline[i]).norm();
  }
  return length;
}

LegTable::LegTable(const LegPlanner& planner, Polyline places, const JobControl& job)
    : planner_(planner), places_(std::move(places)), direct_(places_.size() * places_.size()) {
  ParallelFor(places_.size(), [&](std::size_t i) {
    if (i > 0 && !job.IsCancelled()) FindDirect(0, i);
  });
  job.ThrowIfCancelled();
}

void LegTable::FindDirect(std::size_t from, std::size_t to) {
  Polyline leg = planner_.FindLeg(places_[from], places_[to]);
  direct_[to * places_.size() + from] = Polyline(leg.rbegin(), leg.rend());
  direct_[from * places_.size() + to] = std::move(leg);
}

void LegTable::KeepReached() {
  std::vector<std::size_t> reached;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (IsReached(i)) reached.push_back(i);
  }
  Polyline places;
  std::vector<Polyline> direct(reached.size() * reached.size());
  for (std::size_t i = 0; i < reached.size(); ++i) {
    places.push_back(places_[reached[i]]);
    direct[i] = Direct(0, reached[i]);
    direct[i * reached.size()] = Direct(reached[i], 0);
  }
  places_ = std::move(places);
  direct_ = std::move(direct);
}

std::vector<std::pair<std::size_t, std::size_t>> LegTable::PairsToFind() const {
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  const bool are_few = places_.size() <= kFewPlaces;
  for (std::size_t i = 1; i < places_.size(); ++i) {
    std::vector<std::pair<double, std::size_t>> others;
    for (std::size_t j = 1; j < places_.size(); ++j) {
      if (j != i) others.emplace_back((places_[j] - places_[i]).norm(), j);
    }
    std::sort(others.begin(), others.end());
    if (!are_few) others.resize(std::min(others.size(), kNearestPlaces));
    for (const auto& [distance, j] : others) pairs.emplace(std::min(i, j), std::max(i, j));
  }
  return {pairs.begin(), pairs.end()};
}

void LegTable::FindAll(const JobControl& job) {
  KeepReached();
  const auto pairs = PairsToFind();
  ParallelFor(pairs.size(), [&](std::size_t k) {
    if (!job.IsCancelled()) FindDirect(pairs[k].first, pairs[k].second);
  });
  job.ThrowIfCancelled();
  JoinShortest();
}

// Floyd and Warshall. Every node has a leg from node 0, so every pair is joined.
void LegTable::JoinShortest() {
  const auto n = static_cast<Eigen::Index>(places_.size());
  length_m_ = Eigen::MatrixXd::Constant(n, n, std::numeric_limits<double>::infinity());
  first_stop_ = Eigen::MatrixXi::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Polyline& leg = Direct(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      if (i != j && leg.empty()) continue;
      length_m_(i, j) = i == j ? 0 : LengthOf(leg);
      first_stop_(i, j) = static_cast<int>(j);
    }
  }
  constexpr double kLeastSaving_m = 1e-6;
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        const double by_way_of_k = length_m_(i, k) + length_m_(k, j);
        if (!(by_way_of_k < length_m_(i, j) - kLeastSaving_m)) continue;
        length_m_(i, j) = by_way_of_k;
        first_stop_(i, j) = first_stop_(i, k);
      }
    }
  }
}

Polyline LegTable::Leg(std::size_t from, std::size_t to) const {
  Polyline leg = {places_[from]};
  while (from != to) {
    const auto next = static_cast<std::size_t>(
        first_stop_(static_cast<Eigen::Index>(from), static_cast<Eigen::Index>(to)));
    const Polyline& hop = Direct(from, next);
    leg.insert(leg.end(), hop.begin() + 1, hop.end());
    from = next;
  }
  return leg;
}

}  // namespace colmap_ext
