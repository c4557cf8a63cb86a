#include "colmap_ext/nbv/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "colmap_ext/util/error.h"
#include "nbv/candidates.h"
#include "nbv/reachability.h"
#include "nbv/uncovered_points.h"

namespace colmap_ext {
namespace {

struct Plane {
  std::size_t pitch_index = 0;
  double altitude_m = 0;
  double best_score = 0;  // weighted
};

std::vector<double> EvenPitches(const NextBestViewOptions& options) {
  std::vector<double> pitches;
  const int last = options.num_pitches - 1;
  for (int i = 0; i <= last; ++i) {
    const double t = last == 0 ? 0.5 : static_cast<double>(i) / last;
    pitches.push_back(
        DegToRad(options.min_pitch_deg + t * (options.max_pitch_deg - options.min_pitch_deg)));
  }
  return pitches;
}

std::vector<double> EvenYaws(int num_yaws) {
  std::vector<double> yaws;
  for (int i = 0; i < num_yaws; ++i) yaws.push_back(NormalizeAngle(2 * M_PI * i / num_yaws));
  return yaws;
}

double LowestAltitude(const CoverageMap& coverage, const NextBestViewOptions& options) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const IsoPoint& point : coverage.points) {
    if (point.coverage != CoverageClass::kIgnored) lowest = std::min(lowest, point.position.z());
  }
  return lowest + options.min_altitude_m;
}

// Height of the highest uncovered point that can be reached; nullopt when none can.
std::optional<double> HighestReachable(const UncoveredPoints& points,
                                       const std::vector<std::optional<ReachingView>>& reaching) {
  std::optional<double> highest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!reaching[i]) continue;
    highest = std::max(highest.value_or(points.position(i).z()), points.position(i).z());
  }
  return highest;
}

// The search on all planes for one plan.
class PlaneSweep {
 public:
  // `highest_point_m`: height of the highest uncovered point, z of the world.
  PlaneSweep(const SearchContext& context, double highest_point_m, std::vector<Anchor> anchors,
             UncoveredPoints* points, const JobControl& job)
      : context_(context), points_(points), anchors_(std::move(anchors)), job_(job) {
    for (std::size_t p = 0; p < context.pitches_rad.size(); ++p) AddPlanes(p, highest_point_m);
  }

  // Adds views until there are num_views or nothing scores any more.
  void Run(ViewPlanResult* result) {
    const auto wanted = static_cast<std::size_t>(context_.options.num_views);
    bool is_first = result->views.empty();
    for (bool again = true; again && result->views.size() < wanted;
         again = context_.options.several_planes) {
      ScorePlanes();
      const Plane* plane = ChoosePlane();
      if (plane == nullptr) return;
      if (is_first) {
        result->pitch_rad = context_.pitches_rad[plane->pitch_index];
        result->altitude_m = plane->altitude_m;
      }
      is_first = false;
      if (!ChooseViews(*plane, wanted, &result->views)) return;
    }
  }

 private:
  // The planes of a pitch, in the order in which they are preferred: the paper's, exactly; then
  // downwards; then, for what only a look from further above shows, upwards. All but the first are
  // at multiples of the step, so that planes of different pitches coincide and share work.
  void AddPlanes(std::size_t pitch_index, double highest_point_m) {
    const double pitch = context_.pitches_rad[pitch_index];
    const NextBestViewOptions& options = context_.options;
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
    const double first =
        std::clamp(highest_point_m - options.safe_distance_m * std::sin(pitch), lowest, highest);
    const double step = options.plane_step_m;
    planes_.push_back({pitch_index, first, 0});
    for (double k = std::ceil(first / step) - 1; k * step >= lowest; --k) {
      planes_.push_back({pitch_index, k * step, 0});
    }
    for (double k = std::floor(first / step) + 1; k * step <= highest; ++k) {
      planes_.push_back({pitch_index, k * step, 0});
    }
  }

  // Fills in every plane's best score. Planes at one altitude are evaluated together.
  void ScorePlanes() {
    std::map<double, std::vector<Plane*>> by_altitude;
    for (Plane& plane : planes_) by_altitude[plane.altitude_m].push_back(&plane);
    std::size_t done = 0;
    for (auto& [altitude, planes] : by_altitude) {
      job_.ThrowIfCancelled();
      std::vector<double> pitches;
      for (const Plane* plane : planes) pitches.push_back(context_.pitches_rad[plane->pitch_index]);
      const std::vector<double> best =
          BestScoresOnPlane(context_, *points_, anchors_, altitude, pitches);
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

  // Local maxima with non-maximum suppression: again and again the best candidate that is not near
  // to a chosen one. Returns whether any was chosen.
  bool ChooseViews(const Plane& plane, std::size_t wanted, std::vector<PlannedView>* views) {
    const std::vector<double> pitch = {context_.pitches_rad[plane.pitch_index]};
    std::vector<Candidate> candidates =
        EvaluatePlane(context_, *points_, anchors_, plane.altitude_m, pitch);
    bool any = false;
    while (views->size() < wanted) {
      const Candidate* best = BestApartFrom(*views, candidates);
      if (best == nullptr) break;
      any = true;
      PlannedView view;
      view.position = best->position;
      view.direction = best->direction;
      view.score = PlainScore(*best);
      views->push_back(view);
      for (const SeenPoint& seen : best->seen) points_->AddGoodView(seen.point, best->position);
      if (context_.options.chain_views) {
        anchors_.push_back({view.position, view.direction});
        candidates = EvaluatePlane(context_, *points_, anchors_, plane.altitude_m, pitch);
      }
    }
    return any;
  }

  const Candidate* BestApartFrom(const std::vector<PlannedView>& views,
                                 const std::vector<Candidate>& candidates) const {
    const Candidate* best = nullptr;
    double best_score = 0;
    for (const Candidate& candidate : candidates) {
      const bool is_suppressed =
          std::any_of(views.begin(), views.end(), [&](const PlannedView& view) {
            return (view.position - candidate.position).norm() <= context_.options.nms_radius_m;
          });
      if (is_suppressed) continue;
      const double score = WeightedScore(candidate, *points_);
      if (score > best_score) {
        best = &candidate;
        best_score = score;
      }
    }
    return best;
  }

  const SearchContext& context_;
  UncoveredPoints* points_;
  std::vector<Anchor> anchors_;
  const JobControl& job_;
  std::vector<Plane> planes_;
};

// Adds the bridge's views to the plan, to the anchors, and as good views to what they see.
void AddBridge(const SearchContext& context,
               const std::vector<std::optional<ReachingView>>& reaching,
               std::vector<Anchor>* anchors, UncoveredPoints* points, ViewPlanResult* result) {
  for (const ReachingView& step : FindBridge(context, *anchors, reaching)) {
    const Candidate candidate =
        EvaluatePosition(context, *points, step.position, {step.direction}).front();
    for (const SeenPoint& seen : candidate.seen) points->AddGoodView(seen.point, step.position);
    PlannedView view;
    view.position = step.position;
    view.direction = step.direction;
    view.score = PlainScore(candidate);
    result->views.push_back(view);
    result->pitch_rad = step.direction.pitch_rad;
    result->altitude_m = step.position.z();
    result->is_bridge = true;
  }
  for (const PlannedView& view : result->views) anchors->push_back({view.position, view.direction});
}

}  // namespace

ViewPlanResult PlanNextViews(const CoverageMap& coverage, const TriangleMesh& surface,
                             const std::vector<PosedPhoto>& existing, const PinholeCamera& camera,
                             int first_id, const NextBestViewOptions& options,
                             const JobControl& job,
                             const std::function<bool(const Eigen::Vector3d&)>& may_fly) {
  ThrowIfInvalid(options.Check());
  if (existing.empty())
    throw Error("next best views: there are no registered photos to go on from");
  ViewPlanResult result;
  UncoveredPoints points(coverage, options);
  result.uncovered = points.size();
  if (points.size() == 0) {
    result.stop_reason = "covered";
    return result;
  }

  const VisibilityEngine engine(surface, options.visibility);
  const SearchContext context{options,
                              camera,
                              engine,
                              coverage.min_projection_ratio,
                              LowestAltitude(coverage, options),
                              EvenPitches(options),
                              EvenYaws(options.num_yaws),
                              may_fly};
  std::vector<Anchor> anchors;
  for (const PosedPhoto& photo : existing) {
    anchors.push_back({CameraCenter(photo.cam_from_world), ViewDirectionOf(photo.cam_from_world)});
  }
  points.AddExistingViews(existing, engine, coverage.min_projection_ratio);
  const auto reaching = FindReachingViews(context, points, anchors);
  result.reachable_uncovered = static_cast<std::size_t>(std::count_if(
      reaching.begin(), reaching.end(), [](const auto& view) { return view.has_value(); }));
  job.ThrowIfCancelled();

  const std::optional<double> highest_point_m = HighestReachable(points, reaching);
  if (highest_point_m) {
    PlaneSweep(context, *highest_point_m, anchors, &points, job).Run(&result);
    if (result.views.empty() && options.bridge) {
      AddBridge(context, reaching, &anchors, &points, &result);
      if (result.is_bridge) {
        PlaneSweep(context, *highest_point_m, anchors, &points, job).Run(&result);
      }
    }
  }
  if (result.views.empty()) result.stop_reason = "nothing_reachable";
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    result.views[i].id = first_id + static_cast<int>(i);
  }
  return result;
}

}  // namespace colmap_ext
