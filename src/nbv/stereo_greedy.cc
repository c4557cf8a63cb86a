#include "nbv/stereo_greedy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colmap_ext {
namespace {

constexpr double kLeastGain = 1e-6;
constexpr int kMaxAskAll = 3;  // it takes long

}  // namespace

StereoGreedy::StereoGreedy(const SearchContext& context, const std::vector<PoolView>& pool,
                           const UncoveredPoints& points, const FeatureOverlap& overlap,
                           const Eigen::Vector3d& start)
    : context_(context),
      pool_(pool),
      points_(points),
      overlap_(overlap),
      tour_(start, context.options),
      seen_by_(points.size()),
      gain_(pool.size(), 0),
      is_refused_(pool.size(), 0),
      reach_m_(pool.size(), 0) {
  std::uint32_t num_places = 0;
  for (std::uint32_t v = 0; v < pool.size(); ++v) {
    num_places = std::max(num_places, pool[v].place + 1);
    sun_.push_back(SunFactor(context.options, pool[v].direction));
    for (const std::uint32_t point : pool[v].seen) {
      const auto gain = static_cast<float>(points_.Gain(point, pool[v].position));
      seen_by_[point].push_back({v, gain});
      gain_[v] += static_cast<double>(gain);
      reach_m_[v] += (points_.position(point) - pool[v].position).norm();
    }
  }
  const double reach = 2 * std::sin(0.5 * DegToRad(context.options.max_feature_angle_deg));
  for (std::size_t v = 0; v < pool.size(); ++v) {
    if (!pool[v].seen.empty()) reach_m_[v] *= reach / static_cast<double>(pool[v].seen.size());
  }
  sights_.resize(num_places);
  is_barred_.resize(num_places, 0);
}

double StereoGreedy::Worth(std::size_t view, Rule rule) const {
  const double worth = gain_[view] * sun_[view];
  return rule == Rule::kGain ? worth : worth / tour_.ExtraDuration(pool_[view].position);
}

// The best admissible view; nullopt when there is none.
std::optional<std::size_t> StereoGreedy::Best(Rule rule) {
  const double least = std::max(kLeastGain, context_.options.min_relative_gain * first_gain_);
  std::vector<std::pair<double, std::size_t>> by_worth;
  for (std::size_t v = 0; v < pool_.size(); ++v) {
    if (gain_[v] * sun_[v] < least || is_refused_[v] != 0) continue;
    if (is_barred_[pool_[v].place] != 0) continue;
    by_worth.emplace_back(-Worth(v, rule), v);
  }
  std::make_heap(by_worth.begin(), by_worth.end(), std::greater<>());
  while (!by_worth.empty()) {
    std::pop_heap(by_worth.begin(), by_worth.end(), std::greater<>());
    const std::size_t v = by_worth.back().second;
    by_worth.pop_back();
    const PoolView& view = pool_[v];
    if (is_barred_[view.place] != 0) continue;
    if (!tour_.Permits(view.position)) continue;
    if (!overlap_.IsEnough(view.position, view.direction, &sights_[view.place])) {
      is_refused_[v] = 1;
    } else if (MayReach(context_, view.position)) {
      return v;
    } else {
      is_barred_[view.place] = 1;
    }
  }
  return std::nullopt;
}

void StereoGreedy::UpdatePoint(std::uint32_t point) {
  for (Entry& entry : seen_by_[point]) {
    const auto now = static_cast<float>(points_.Gain(point, pool_[entry.view].position));
    gain_[entry.view] += static_cast<double>(now) - static_cast<double>(entry.gain);
    entry.gain = now;
  }
}

// Refused views are asked again once a view like them is there: at a distance and in a direction
// between which features are matched.
void StereoGreedy::AskAgain(const PoolView& added) {
  const Eigen::Vector3d look = DirectionInWorld(added.direction);
  constexpr double kCosAlike = 0.7;  // 45 degrees
  for (std::size_t v = 0; v < pool_.size(); ++v) {
    if (is_refused_[v] == 0 || (pool_[v].position - added.position).norm() > reach_m_[v] ||
        DirectionInWorld(pool_[v].direction).dot(look) < kCosAlike) {
      continue;
    }
    is_refused_[v] = 0;
  }
}

bool StereoGreedy::Add(const PoolView& view) {
  if (!tour_.Permits(view.position)) return false;
  const bool is_asked = context_.options.min_shared_features > 0;
  shared_.push_back(is_asked ? overlap_.AddView(view.position, view.direction) : -1);
  if (is_asked) AskAgain(view);
  tour_.Insert(view.position);
  for (const std::uint32_t point : view.seen) {
    if (points_.IsSatisfied(point)) continue;
    coverage_ += points_.Gain(point, view.position);
    points_.AddGoodView(point, view.position);
    UpdatePoint(point);
  }
  views_.push_back(view);
  return true;
}

void StereoGreedy::Run(Rule rule, const JobControl& job) {
  const auto wanted = static_cast<std::size_t>(context_.options.num_views);
  while (views_.size() < wanted) {
    job.ThrowIfCancelled();
    const std::optional<std::size_t> best = Best(rule);
    if (!best) {
      // Those that no view nearby has been added for may have come within reach all the same.
      if (times_asked_all_ == kMaxAskAll || asked_all_at_ == views_.size()) return;
      ++times_asked_all_;
      asked_all_at_ = views_.size();
      std::fill(is_refused_.begin(), is_refused_.end(), 0);
      continue;
    }
    first_gain_ = std::max(first_gain_, gain_[*best] * sun_[*best]);
    Add(pool_[*best]);
    job.Progress("next best views", views_.size(), wanted);
  }
}

std::vector<std::size_t> StereoGreedy::Wanting(std::size_t count) const {
  std::vector<std::size_t> views;
  for (std::size_t v = 0; v < pool_.size(); ++v) {
    if (gain_[v] > kLeastGain && is_barred_[pool_[v].place] == 0 &&
        tour_.Permits(pool_[v].position))
      views.push_back(v);
  }
  std::stable_sort(views.begin(), views.end(),
                   [&](std::size_t a, std::size_t b) { return gain_[a] > gain_[b]; });
  views.resize(std::min(views.size(), count));
  return views;
}

}  // namespace colmap_ext
