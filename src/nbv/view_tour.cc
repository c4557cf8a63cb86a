#include "nbv/view_tour.h"

#include <algorithm>
#include <limits>

namespace colmap_ext {
namespace {

constexpr double kTypicalTurn_deg = 45;

}  // namespace

ViewTour::ViewTour(const Eigen::Vector3d& start, const NextBestViewOptions& options)
    : options_(options), start_(start) {}

const Eigen::Vector3d& ViewTour::At(std::size_t k) const {
  return k == 0 ? start_ : stops_[order_[k - 1]];
}

double ViewTour::Leg(std::size_t k) const {
  if (k < order_.size()) return (At(k + 1) - At(k)).norm();
  return options_.return_to_start ? (start_ - At(k)).norm() : 0;
}

std::size_t ViewTour::CheapestPlace(const Eigen::Vector3d& position, double* extra_m) const {
  std::size_t best = order_.size();
  *extra_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k <= order_.size(); ++k) {  // between the k-th place and the next one
    double extra = (position - At(k)).norm() - Leg(k);
    if (k < order_.size()) {
      extra += (At(k + 1) - position).norm();
    } else if (options_.return_to_start) {
      extra += (start_ - position).norm();
    }
    if (extra < *extra_m) {
      *extra_m = extra;
      best = k;
    }
  }
  return best;
}

double ViewTour::ExtraLength(const Eigen::Vector3d& position) const {
  double extra_m = 0;
  CheapestPlace(position, &extra_m);
  return extra_m;
}

double ViewTour::ExtraDuration(const Eigen::Vector3d& position) const {
  return ExtraLength(position) / options_.speed_m_s + options_.hover_s +
         kTypicalTurn_deg / options_.yaw_rate_deg_s;
}

bool ViewTour::Permits(const Eigen::Vector3d& position) const {
  if (options_.max_tour_length_m > 0 &&
      length_m_ + ExtraLength(position) > options_.max_tour_length_m) {
    return false;
  }
  return options_.max_tour_duration_s <= 0 ||
         duration_s() + ExtraDuration(position) <= options_.max_tour_duration_s;
}

double ViewTour::duration_s() const {
  const auto count = static_cast<double>(order_.size());
  return length_m_ / options_.speed_m_s +
         count * (options_.hover_s + kTypicalTurn_deg / options_.yaw_rate_deg_s);
}

void ViewTour::Insert(const Eigen::Vector3d& position) {
  double extra_m = 0;
  const std::size_t place = CheapestPlace(position, &extra_m);
  order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(place), stops_.size());
  stops_.push_back(position);
  length_m_ += extra_m;
  constexpr std::size_t kFew = 30, kEvery = 16;
  if (stops_.size() <= kFew || stops_.size() % kEvery == 0) Improve();
}

// 2-opt: turns the part between two legs round while that makes the tour shorter.
void ViewTour::Improve() {
  const std::size_t n = order_.size();
  constexpr std::size_t kMaxStops = 200;  // beyond, it takes longer than it is worth
  if (n > kMaxStops) return;
  constexpr int kMaxPasses = 3;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    bool is_better = false;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      for (std::size_t j = i + 2; j <= n; ++j) {  // legs i and j; the stops between turn round
        const bool is_open_end = j == n && !options_.return_to_start;
        const Eigen::Vector3d& after = j < n ? At(j + 1) : start_;
        const double now = Leg(i) + Leg(j);
        const double turned =
            (At(j) - At(i)).norm() + (is_open_end ? 0 : (after - At(i + 1)).norm());
        if (turned < now - 1e-9) {
          std::reverse(order_.begin() + static_cast<std::ptrdiff_t>(i),
                       order_.begin() + static_cast<std::ptrdiff_t>(j));
          is_better = true;
        }
      }
    }
    if (!is_better) break;
  }
  length_m_ = 0;
  for (std::size_t k = 0; k <= n; ++k) length_m_ += Leg(k);
}

}  // namespace colmap_ext
