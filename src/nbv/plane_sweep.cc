#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "nbv/candidates.h"
#include "nbv/feature_overlap.h"
#include "nbv/reachability.h"
#include "nbv/strategies.h"

namespace colmap_ext {
namespace {

struct Plane {
  std::size_t pitch_index = 0;
  double altitude_m = 0;
  double best_score = 0;  // weighted
};

// Height of the highest of the points for which `counts`; nullopt when there is none.
template <typename Counts>
std::optional<double> HighestPoint(const UncoveredPoints& points, const Counts& counts) {
  std::optional<double> highest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!counts(i)) continue;
    highest = std::max(highest.value_or(points.position(i).z()), points.position(i).z());
  }
  return highest;
}

void AddChosenView(const SearchContext& context, const Candidate& chosen, FeatureOverlap* overlap,
                   ViewPlanResult* result) {
  PlannedView view;
  view.position = chosen.position;
  view.direction = chosen.direction;
  view.score = PlainScore(chosen);
  result->views.push_back(view);
  const bool is_asked = overlap != nullptr && context.options.min_shared_features > 0;
  result->shared_features.push_back(is_asked ? overlap->AddView(view.position, view.direction)
                                             : -1);
}

// The search on all planes for one plan.
class PlaneSweep {
 public:
  // `highest_point_m`: height of the highest uncovered point, z of the world.
  PlaneSweep(const SearchContext& context, double highest_point_m, std::vector<Anchor> anchors,
             UncoveredPoints* points, FeatureOverlap* overlap, const JobControl& job)
      : context_(context),
        points_(points),
        overlap_(overlap),
        anchors_(std::move(anchors)),
        job_(job),
        step_(context.options.paper_only ? 1 : context.options.coarse_step) {
    for (std::size_t p = 0; p < context.pitches_rad.size(); ++p) AddPlanes(p, highest_point_m);
  }

  // Adds views until there are num_views or nothing scores any more.
  void Run(ViewPlanResult* result) {
    const auto wanted = static_cast<std::size_t>(context_.options.num_views);
    bool is_first = result->views.empty();
    int failures = 0;
    for (bool again = true; again && result->views.size() < wanted;
         again = context_.options.several_planes && !context_.options.paper_only) {
      const Plane* plane = BestPlane();
      if (plane == nullptr) return;
      if (is_first) {
        result->pitch_rad = context_.pitches_rad[plane->pitch_index];
        result->altitude_m = plane->altitude_m;
      }
      is_first = false;
      // Where SfM could register none of a plane's views, the next one may do better.
      constexpr int kMaxFailures = 6;
      failures = ChooseViews(*plane, wanted, result) ? 0 : failures + 1;
      if (failures > kMaxFailures) return;
    }
  }

 private:
  // The planes of a pitch, in the order in which they are preferred: the paper's, exactly; then
  // downwards; then, for what only a look from further above shows, upwards. All but the first are
  // at multiples of the step, so that planes of different pitches coincide and share work.
  void AddPlanes(std::size_t pitch_index, double highest_point_m) {
    const double pitch = context_.pitches_rad[pitch_index];
    const NextBestViewOptions& options = context_.options;
    const double papers = highest_point_m - options.safe_distance_m * std::sin(pitch);
    if (options.paper_only) {
      planes_.push_back({pitch_index, papers, 0});
      return;
    }
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    for (const Anchor& anchor : anchors_) {
      if (!IsNearInAngle(options, anchor.direction.pitch_rad, pitch)) continue;
      lowest = std::min(lowest, anchor.position.z() - options.max_distance_to_existing_m);
      highest = std::max(highest, anchor.position.z() + options.max_distance_to_existing_m);
    }
    lowest = std::max(lowest, context_.lowest_altitude_m);
    if (options.max_altitude_m != 0) highest = std::min(highest, options.max_altitude_m);
    if (!(lowest <= highest)) return;
    const double first = std::clamp(papers, lowest, highest);
    const double step = options.plane_step_m;
    planes_.push_back({pitch_index, first, 0});
    for (double k = std::ceil(first / step) - 1; k * step >= lowest; --k) {
      planes_.push_back({pitch_index, k * step, 0});
    }
    for (double k = std::floor(first / step) + 1; k * step <= highest; ++k) {
      planes_.push_back({pitch_index, k * step, 0});
    }
  }

  // The plane that is next; where the coarse grid shows nothing, the full one is searched.
  const Plane* BestPlane() {
    ScorePlanes();
    const Plane* plane = ChoosePlane();
    if (plane != nullptr || step_ == 1) return plane;
    step_ = 1;
    places_.clear();
    ScorePlanes();
    return ChoosePlane();
  }

  // Fills in every plane's best score. Planes at one altitude are evaluated together; what is
  // visible from their positions is kept for the next time.
  void ScorePlanes() {
    std::map<double, std::vector<Plane*>> by_altitude;
    for (Plane& plane : planes_) by_altitude[plane.altitude_m].push_back(&plane);
    std::size_t done = 0;
    for (auto& [altitude, planes] : by_altitude) {
      job_.ThrowIfCancelled();
      std::vector<double> pitches;
      for (const Plane* plane : planes) pitches.push_back(context_.pitches_rad[plane->pitch_index]);
      auto known = places_.find(altitude);
      if (known == places_.end()) {
        known = places_
                    .emplace(altitude,
                             PlacesOnPlane(context_, *points_, anchors_, altitude, pitches, step_))
                    .first;
      }
      const std::vector<double> best = BestScores(context_, *points_, known->second, pitches);
      for (std::size_t i = 0; i < planes.size(); ++i) planes[i]->best_score = best[i];
      job_.Progress("next best views", ++done, by_altitude.size());
    }
  }

  // Of each pitch the first acceptable plane, and of these the best. Null when nothing scores.
  const Plane* ChoosePlane() const {
    std::vector<double> best_of_pitch(context_.pitches_rad.size(), 0);
    for (const Plane& plane : planes_) {
      double& best = best_of_pitch[plane.pitch_index];
      best = std::max(best, plane.best_score);
    }
    std::vector<const Plane*> accepted(context_.pitches_rad.size(), nullptr);
    for (const Plane& plane : planes_) {
      if (IsUsedUp(plane)) continue;
      const Plane*& of_pitch = accepted[plane.pitch_index];
      const double least = context_.options.min_relative_score * best_of_pitch[plane.pitch_index];
      if (of_pitch == nullptr && plane.best_score > 0 && plane.best_score >= least) {
        of_pitch = &plane;
      }
    }
    const Plane* chosen = nullptr;
    for (const Plane* plane : accepted) {
      if (plane == nullptr) continue;
      if (chosen == nullptr || plane->best_score > chosen->best_score) chosen = plane;
    }
    return chosen;
  }

  bool IsUsedUp(const Plane& plane) const {
    return std::find(used_up_.begin(), used_up_.end(), &plane) != used_up_.end();
  }

  std::vector<Candidate> CandidatesOn(const Plane& plane) const {
    const std::vector<double> pitch = {context_.pitches_rad[plane.pitch_index]};
    return CandidatesOf(context_, *points_,
                        PlacesOnPlane(context_, *points_, anchors_, plane.altitude_m, pitch, 1));
  }

  // Local maxima with non-maximum suppression: again and again the best candidate that is not near
  // to a chosen one and can be registered. Returns whether any was chosen.
  bool ChooseViews(const Plane& plane, std::size_t wanted, ViewPlanResult* result) {
    std::vector<Candidate> candidates = CandidatesOn(plane);
    bool any = false;
    while (result->views.size() < wanted) {
      const Candidate* best = BestApartFrom(result->views, &candidates);
      if (best == nullptr) break;
      any = true;
      const Anchor chosen{best->position, best->direction};
      for (const SeenPoint& seen : best->seen) points_->AddGoodView(seen.point, best->position);
      AddChosenView(context_, *best, overlap_, result);
      if (context_.options.chain_views && !context_.options.paper_only) {
        anchors_.push_back(chosen);
        places_.clear();
        candidates = CandidatesOn(plane);
      }
    }
    used_up_.push_back(&plane);
    return any;
  }

  // Candidates that share too few features, or that no way leads to, lose what they see.
  const Candidate* BestApartFrom(const std::vector<PlannedView>& views,
                                 std::vector<Candidate>* candidates) const {
    for (;;) {
      Candidate* best = nullptr;
      double best_score = 0;
      for (Candidate& candidate : *candidates) {
        const bool is_suppressed =
            std::any_of(views.begin(), views.end(), [&](const PlannedView& view) {
              return (view.position - candidate.position).norm() <= context_.options.nms_radius_m;
            });
        if (is_suppressed) continue;
        const double score = WeightedScore(context_, candidate, *points_);
        if (score > best_score) {
          best = &candidate;
          best_score = score;
        }
      }
      if (best == nullptr) return nullptr;
      FeatureOverlap::Sight sight;
      if ((overlap_ == nullptr || overlap_->IsEnough(best->position, best->direction, &sight)) &&
          MayReach(context_, best->position)) {
        return best;
      }
      best->seen.clear();
    }
  }

  const SearchContext& context_;
  UncoveredPoints* points_;
  FeatureOverlap* overlap_;  // null: not asked
  std::vector<Anchor> anchors_;
  const JobControl& job_;
  int step_;
  std::vector<Plane> planes_;
  std::vector<const Plane*> used_up_;
  std::map<double, std::vector<PlanePlace>> places_;  // by altitude
};

// Adds the bridge's views to the plan, to the anchors, and as good views to what they see; stops
// before one that could not be registered.
void AddBridge(const SearchContext& context,
               const std::vector<std::optional<ReachingView>>& reaching,
               std::vector<Anchor>* anchors, UncoveredPoints* points, FeatureOverlap* overlap,
               ViewPlanResult* result) {
  for (const ReachingView& step : FindBridge(context, *anchors, reaching)) {
    FeatureOverlap::Sight sight;
    if (!overlap->IsEnough(step.position, step.direction, &sight)) break;
    const Candidate candidate = EvaluateCandidate(context, *points, step.position, step.direction);
    for (const SeenPoint& seen : candidate.seen) points->AddGoodView(seen.point, step.position);
    AddChosenView(context, candidate, overlap, result);
    result->pitch_rad = step.direction.pitch_rad;
    result->altitude_m = step.position.z();
    result->is_bridge = true;
  }
  for (const PlannedView& view : result->views) anchors->push_back({view.position, view.direction});
}

void RunPaper(const SearchContext& context, UncoveredPoints* points,
              const std::vector<Anchor>& anchors, const JobControl& job, ViewPlanResult* result) {
  const auto highest_m = HighestPoint(*points, [](std::size_t) { return true; });
  result->reachable_uncovered = points->size();
  PlaneSweep(context, *highest_m, anchors, points, nullptr, job).Run(result);
}

}  // namespace

void RunPlaneSweep(const SearchContext& context, const std::vector<Anchor>& given,
                   const JobControl& job, ViewPlanResult* result) {
  const CoverageMap& coverage = context.input.coverage;
  UncoveredPoints points(coverage, IndicesOfUncovered(coverage), context.options);
  if (context.options.paper_only) {
    RunPaper(context, &points, given, job, result);
    return;
  }
  std::vector<Anchor> anchors = given;
  points.AddExistingViews(context.input.existing, context.engine, coverage.min_projection_ratio);
  const auto reaching = FindReachingViews(context, points, anchors);
  result->reachable_uncovered = static_cast<std::size_t>(std::count_if(
      reaching.begin(), reaching.end(), [](const auto& view) { return view.has_value(); }));
  job.ThrowIfCancelled();
  const auto highest_m =
      HighestPoint(points, [&](std::size_t i) { return reaching[i].has_value(); });
  if (!highest_m) return;

  FeatureOverlap overlap(context);
  PlaneSweep(context, *highest_m, anchors, &points, &overlap, job).Run(result);
  if (!result->views.empty() || !context.options.bridge) return;
  AddBridge(context, reaching, &anchors, &points, &overlap, result);
  if (result->is_bridge) {
    PlaneSweep(context, *highest_m, anchors, &points, &overlap, job).Run(result);
  }
}

}  // namespace colmap_ext
