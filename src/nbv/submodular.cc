#include <algorithm>
#include <cmath>
#include <optional>

#include "nbv/reachability.h"
#include "nbv/stereo_greedy.h"
#include "nbv/strategies.h"

namespace colmap_ext {
namespace {

// Points that no view of the pool sees are looked at one by one, but no more than so many.
constexpr std::size_t kMaxSearched = 200;

struct Candidates {
  std::vector<PoolView> views;
  double part_reachable = 0;  // of the points
};

// The pool, and for points that no view of it sees the first view that is found from any free
// position; when there is none at all, from everywhere.
Candidates FindCandidates(const SearchContext& context, const UncoveredPoints& points,
                          const std::vector<std::size_t>& indices,
                          const std::vector<Anchor>& anchors) {
  ViewPool pool = BuildViewPool(context, points);
  const std::vector<char> is_seen = SeenByAny(pool.views, points.size());
  std::vector<std::size_t> unseen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_seen[i] == 0) unseen.push_back(indices[i]);
  }
  const std::vector<std::size_t> searched = Strided(unseen, kMaxSearched);
  UncoveredPoints rest(context.input.coverage, searched, context.options);
  rest.AddExistingViews(context.input.existing, context.engine,
                        context.input.coverage.min_projection_ratio);
  const auto reaching = pool.views.empty() ? FindReachingViews(context, rest, anchors)
                                           : FindReachingViews(context, rest, pool.free_positions);
  Candidates candidates{std::move(pool.views), 0};
  std::size_t found = 0;
  std::uint32_t place = candidates.views.empty() ? 0 : candidates.views.back().place;
  for (const std::optional<ReachingView>& view : reaching) {
    if (!view) continue;
    ++found;
    PoolView candidate = EvaluateView(context, points, view->position, view->direction);
    candidate.place = ++place;
    if (!candidate.seen.empty()) candidates.views.push_back(std::move(candidate));
  }
  const auto num_seen = static_cast<double>(points.size() - unseen.size());
  const double part_found =
      searched.empty() ? 0 : static_cast<double>(found) / static_cast<double>(searched.size());
  candidates.part_reachable = (num_seen + part_found * static_cast<double>(unseen.size())) /
                              static_cast<double>(points.size());
  return candidates;
}

// Views that lead on to one that gains but shares too few features: those of the shortest chain
// that can be registered. Returns whether there are any.
bool AddBridge(const SearchContext& context, const UncoveredPoints& points,
               const std::vector<PoolView>& pool, const std::vector<Anchor>& anchors,
               StereoGreedy* greedy) {
  constexpr std::size_t kMaxTargets = 200;
  std::vector<std::optional<ReachingView>> targets;
  for (const std::size_t v : greedy->Wanting(kMaxTargets)) {
    targets.push_back(ReachingView{pool[v].position, pool[v].direction});
  }
  std::vector<Anchor> from = anchors;
  for (const PoolView& view : greedy->views()) from.push_back({view.position, view.direction});
  bool any = false;
  for (const ReachingView& step : FindBridge(context, from, targets)) {
    if (greedy->views().size() >= static_cast<std::size_t>(context.options.num_views)) break;
    FeatureOverlap::Sight sight;
    if (!greedy->overlap().IsEnough(step.position, step.direction, &sight)) break;
    if (!greedy->Add(EvaluateView(context, points, step.position, step.direction))) break;
    any = true;
  }
  return any;
}

void TakeViews(const StereoGreedy& greedy, ViewPlanResult* result) {
  for (const std::size_t k : greedy.tour().order()) {
    const PoolView& chosen = greedy.views()[k];
    PlannedView view;
    view.position = chosen.position;
    view.direction = chosen.direction;
    result->views.push_back(view);
    result->shared_features.push_back(greedy.shared_features()[k]);
  }
}

bool HasTourBudget(const NextBestViewOptions& options) {
  return options.max_tour_length_m > 0 || options.max_tour_duration_s > 0;
}

}  // namespace

void RunSubmodular(const SearchContext& context, const std::vector<Anchor>& anchors,
                   const JobControl& job, ViewPlanResult* result) {
  const CoverageMap& coverage = context.input.coverage;
  const std::vector<std::size_t> indices =
      Strided(IndicesOfUncovered(coverage), static_cast<std::size_t>(context.options.num_points));
  UncoveredPoints points(coverage, indices, context.options);
  points.AddExistingViews(context.input.existing, context.engine, coverage.min_projection_ratio);
  if (context.options.objective == "predicted_error") {
    points.PreferAccuracy(context.camera().fx * context.camera().fy, coverage.min_projection_ratio);
  }
  job.ThrowIfCancelled();
  const Candidates pool = FindCandidates(context, points, indices, anchors);
  result->reachable_uncovered = static_cast<std::size_t>(
      std::lround(pool.part_reachable * static_cast<double>(result->uncovered)));
  job.ThrowIfCancelled();

  using Rule = StereoGreedy::Rule;
  StereoGreedy best(context, pool.views, points, FeatureOverlap(context), StartOf(context.input));
  std::optional<StereoGreedy> other;
  if (HasTourBudget(context.options)) other.emplace(best);
  best.Run(Rule::kGain, job);
  if (other) other->Run(Rule::kGainForTime, job);
  StereoGreedy& chosen = other && other->coverage() > best.coverage() ? *other : best;
  if (chosen.views().empty() && context.options.bridge &&
      AddBridge(context, points, pool.views, anchors, &chosen)) {
    result->is_bridge = true;
    chosen.Run(Rule::kGain, job);
  }
  chosen.PolishTour();
  TakeViews(chosen, result);
  result->tour_length_m = chosen.tour().length_m();
  result->tour_duration_s = chosen.tour().duration_s();
}

}  // namespace colmap_ext
