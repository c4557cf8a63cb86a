#include <algorithm>
#include <limits>

#include "colmap_ext/util/statistics.h"
#include "nbv/feature_overlap.h"
#include "nbv/strategies.h"
#include "nbv/view_pool.h"
#include "nbv/view_tour.h"

namespace colmap_ext {
namespace {

// Picks views of a pool one after the other.
class Picker {
 public:
  Picker(const SearchContext& context, const std::vector<PoolView>& pool)
      : context_(context),
        pool_(pool),
        overlap_(context),
        tour_(StartOf(context.input), context.options),
        is_used_(pool.size(), 0),
        distance_m_(pool.size(), std::numeric_limits<double>::infinity()) {
    std::uint32_t num_places = 0;
    for (const PoolView& view : pool) num_places = std::max(num_places, view.place + 1);
    sights_.resize(num_places);
    for (const PosedPhoto& photo : context.input.existing) {
      NoteView(CameraCenter(photo.cam_from_world));
    }
  }

  // The first of `order`, or the furthest from all views so far, that can be registered and flown.
  bool PickOne(const std::vector<std::size_t>& order, bool furthest) {
    std::vector<std::size_t> by_rank = order;
    if (furthest) {
      std::stable_sort(by_rank.begin(), by_rank.end(), [&](std::size_t a, std::size_t b) {
        return distance_m_[a] > distance_m_[b];
      });
    }
    for (const std::size_t v : by_rank) {
      const PoolView& view = pool_[v];
      if (is_used_[v] != 0 || !tour_.Permits(view.position) ||
          !overlap_.IsEnough(view.position, view.direction, &sights_[view.place])) {
        continue;
      }
      is_used_[v] = 1;
      const bool is_asked = context_.options.min_shared_features > 0;
      shared_.push_back(is_asked ? overlap_.AddView(view.position, view.direction) : -1);
      tour_.Insert(view.position);
      NoteView(view.position);
      picked_.push_back(v);
      return true;
    }
    return false;
  }

  void Take(ViewPlanResult* result) {
    tour_.Improve();
    for (const std::size_t k : tour_.order()) {
      PlannedView view;
      view.position = pool_[picked_[k]].position;
      view.direction = pool_[picked_[k]].direction;
      result->views.push_back(view);
      result->shared_features.push_back(shared_[k]);
    }
    result->tour_length_m = tour_.length_m();
    result->tour_duration_s = tour_.duration_s();
  }

 private:
  void NoteView(const Eigen::Vector3d& position) {
    for (std::size_t v = 0; v < pool_.size(); ++v) {
      distance_m_[v] = std::min(distance_m_[v], (pool_[v].position - position).norm());
    }
  }

  const SearchContext& context_;
  const std::vector<PoolView>& pool_;
  FeatureOverlap overlap_;
  ViewTour tour_;
  std::vector<char> is_used_;
  std::vector<double> distance_m_;  // to the nearest view so far
  std::vector<FeatureOverlap::Sight> sights_;
  std::vector<std::size_t> picked_;
  std::vector<double> shared_;
};

}  // namespace

void RunBaseline(const SearchContext& context, const JobControl& job, ViewPlanResult* result) {
  const NextBestViewOptions& options = context.options;
  const CoverageMap& coverage = context.input.coverage;
  // Blind: all that is to be covered counts, whatever is covered already.
  const UncoveredPoints points(
      coverage, Strided(IndicesOfWanted(coverage), static_cast<std::size_t>(options.num_points)),
      options);
  const std::vector<PoolView> pool = BuildViewPool(context, points).views;
  std::vector<char> is_seen(points.size(), 0);
  for (const PoolView& view : pool) {
    for (const std::uint32_t point : view.seen) is_seen[point] = 1;
  }
  const auto num_seen = static_cast<double>(std::count(is_seen.begin(), is_seen.end(), 1));
  result->reachable_uncovered = static_cast<std::size_t>(
      num_seen / static_cast<double>(points.size()) * static_cast<double>(result->uncovered));
  // Another order in each iteration of a session.
  const std::vector<std::size_t> order =
      RandomOrder(pool.size(), options.seed * 1000003 + context.input.existing.size());
  Picker picker(context, pool);
  for (int i = 0; i < options.num_views; ++i) {
    job.ThrowIfCancelled();
    if (!picker.PickOne(order, options.strategy == "next_farthest_point")) break;
  }
  picker.Take(result);
}

}  // namespace colmap_ext
