#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "nbv/feature_overlap.h"
#include "nbv/reconstructability.h"
#include "nbv/strategies.h"
#include "nbv/view_pool.h"
#include "nbv/view_tour.h"

namespace colmap_ext {
namespace {

// An offline plan in the manner of Smith et al. 2018: all of the coarse model counts, whatever is
// covered already. Theirs starts from a regular grid over a height map and moves all views by the
// downhill simplex; ours starts from a greedy choice of a pool, and moves each view by a pattern
// search, because it must go on from existing photos and stay registrable.
class SmithPlanner {
 public:
  SmithPlanner(const SearchContext& context, const UncoveredPoints& points,
               std::vector<PoolView> pool)
      : context_(context),
        points_(points),
        pool_(std::move(pool)),
        heuristic_(context, points, context.input.existing),
        overlap_(std::in_place, context) {}

  void Choose(const JobControl& job) {
    // Before any is moved: which views the budget permits.
    ViewTour tour(StartOf(context_.input), context_.options);
    double first_gain = 0;
    std::vector<char> is_out(pool_.size(), 0);
    while (views_.size() < static_cast<std::size_t>(context_.options.num_views)) {
      job.ThrowIfCancelled();
      const std::optional<std::size_t> best = BestOfPool(tour, &is_out);
      if (!best) return;
      const double gain = heuristic_.Gain(pool_[*best].position, pool_[*best].seen);
      first_gain = std::max(first_gain, gain);
      if (gain <= context_.options.min_relative_gain * first_gain) return;
      is_out[*best] = 1;
      tour.Insert(pool_[*best].position);
      heuristic_.Add(pool_[*best].position, pool_[*best].seen);
      overlap_->AddView(pool_[*best].position, pool_[*best].direction);
      views_.push_back(pool_[*best]);
    }
  }

  // Every view in turn, steps halved from one round to the next. Each must be registrable by those
  // before it where they are now.
  void Refine(const JobControl& job) {
    overlap_.emplace(context_);
    std::vector<PoolView> kept;
    for (PoolView& view : views_) {
      job.ThrowIfCancelled();
      constexpr int kRounds = 3;
      double step_m = 2 * context_.options.grid_spacing_m;
      double turn_rad = DegToRad(10);
      for (int round = 0; round < kRounds; ++round, step_m /= 2, turn_rad /= 2) {
        Improve(step_m, turn_rad, &view);
      }
      FeatureOverlap::Sight sight;
      if (!overlap_->IsEnough(view.position, view.direction, &sight)) {
        heuristic_.Remove(view.position, view.seen);
        continue;
      }
      const bool is_asked = context_.options.min_shared_features > 0;
      shared_.push_back(is_asked ? overlap_->AddView(view.position, view.direction) : -1);
      kept.push_back(view);
    }
    views_ = std::move(kept);
  }

  void Take(ViewPlanResult* result) const {
    ViewTour tour(StartOf(context_.input), context_.options);
    for (const PoolView& view : views_) tour.Insert(view.position);
    tour.Improve();
    for (const std::size_t k : tour.order()) {
      PlannedView view;
      view.position = views_[k].position;
      view.direction = views_[k].direction;
      result->views.push_back(view);
      result->shared_features.push_back(shared_[k]);
    }
    result->tour_length_m = tour.length_m();
    result->tour_duration_s = tour.duration_s();
  }

 private:
  std::optional<std::size_t> BestOfPool(const ViewTour& tour, std::vector<char>* is_out) const {
    std::vector<std::pair<double, std::size_t>> by_gain;
    for (std::size_t v = 0; v < pool_.size(); ++v) {
      if ((*is_out)[v] != 0) continue;
      by_gain.emplace_back(heuristic_.Gain(pool_[v].position, pool_[v].seen), v);
    }
    std::stable_sort(by_gain.begin(), by_gain.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [gain, v] : by_gain) {
      if (gain <= 0) break;
      const PoolView& view = pool_[v];
      FeatureOverlap::Sight sight;
      if (!tour.Permits(view.position) ||
          !overlap_->IsEnough(view.position, view.direction, &sight)) {
        continue;
      }
      if (MayReach(context_, view.position)) return v;
      (*is_out)[v] = 1;
    }
    return std::nullopt;
  }

  // The view as it would be elsewhere; nullopt where it may not be.
  std::optional<PoolView> Moved(const PoolView& view, const Eigen::Vector3d& by_m, double yaw_rad,
                                double pitch_rad) const {
    const Eigen::Vector3d position = view.position + by_m;
    const ViewDirection direction{NormalizeAngle(view.direction.yaw_rad + yaw_rad),
                                  view.direction.pitch_rad + pitch_rad};
    const double pitch_deg = RadToDeg(direction.pitch_rad);
    const bool is_budget_free =
        context_.options.max_tour_length_m <= 0 && context_.options.max_tour_duration_s <= 0;
    if (pitch_deg < context_.options.min_gimbal_pitch_deg ||
        pitch_deg > context_.options.max_gimbal_pitch_deg ||
        (!is_budget_free && by_m.squaredNorm() > 0) || !IsFreePosition(context_, position)) {
      return std::nullopt;
    }
    FeatureOverlap::Sight sight;
    if (!overlap_->IsEnough(position, direction, &sight) || !MayReach(context_, position)) {
      return std::nullopt;
    }
    return EvaluateView(context_, points_, position, direction);
  }

  void Improve(double step_m, double turn_rad, PoolView* view) {
    heuristic_.Remove(view->position, view->seen);
    double gain = heuristic_.Gain(view->position, view->seen);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 5; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        const Eigen::Vector3d by_m =
            axis < 3 ? Eigen::Vector3d(sign * step_m * Eigen::Vector3d::Unit(axis)) : none;
        const std::optional<PoolView> moved =
            Moved(*view, by_m, axis == 3 ? sign * turn_rad : 0, axis == 4 ? sign * turn_rad : 0);
        if (!moved) continue;
        const double moved_gain = heuristic_.Gain(moved->position, moved->seen);
        if (moved_gain <= gain) continue;
        gain = moved_gain;
        *view = *moved;
        break;
      }
    }
    heuristic_.Add(view->position, view->seen);
  }

  const SearchContext& context_;
  const UncoveredPoints& points_;
  std::vector<PoolView> pool_;
  Reconstructability heuristic_;
  std::optional<FeatureOverlap> overlap_;
  std::vector<PoolView> views_;
  std::vector<double> shared_;
};

}  // namespace

void RunSmith2018(const SearchContext& context, const JobControl& job, ViewPlanResult* result) {
  const CoverageMap& coverage = context.input.coverage;
  const UncoveredPoints points(
      coverage,
      Strided(IndicesOfWanted(coverage), static_cast<std::size_t>(context.options.num_points)),
      context.options);
  std::vector<PoolView> pool = BuildViewPool(context, points).views;
  result->reachable_uncovered = PartSeen(pool, points.size(), result->uncovered);
  SmithPlanner planner(context, points, std::move(pool));
  planner.Choose(job);
  planner.Refine(job);
  planner.Take(result);
}

}  // namespace colmap_ext
