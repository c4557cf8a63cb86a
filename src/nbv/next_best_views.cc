#include "colmap_ext/nbv/next_best_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "nbv/strategies.h"
#include "nbv/uncovered_points.h"
#include "nbv/view_fan.h"
#include "nbv/view_tour.h"

namespace colmap_ext {
namespace {

bool IsPlaneSweep(const NextBestViewOptions& options) { return options.strategy == "plane_sweep"; }

// Those of the paper, or all that the gimbal can do every 10 degrees.
std::vector<double> Pitches(const NextBestViewOptions& options) {
  const double lowest = options.min_gimbal_pitch_deg;
  const double highest = options.max_gimbal_pitch_deg;
  std::vector<double> pitches;
  if (IsPlaneSweep(options)) {
    const int last = options.num_pitches - 1;
    for (int i = 0; i <= last; ++i) {
      const double t = last == 0 ? 0.5 : static_cast<double>(i) / last;
      const double pitch =
          options.min_pitch_deg + t * (options.max_pitch_deg - options.min_pitch_deg);
      if (pitch >= lowest - 1e-9 && pitch <= highest + 1e-9) pitches.push_back(DegToRad(pitch));
    }
    return pitches;
  }
  constexpr double kStep_deg = 10;
  const int steps = static_cast<int>(std::ceil((highest - lowest) / kStep_deg));
  for (int i = 0; i <= steps; ++i) {
    pitches.push_back(DegToRad(lowest + (steps == 0 ? 0 : i * (highest - lowest) / steps)));
  }
  return pitches;
}

std::vector<double> Yaws(const NextBestViewOptions& options) {
  constexpr int kFreeYaws = 16;
  const int count = IsPlaneSweep(options) ? options.num_yaws : kFreeYaws;
  std::vector<double> yaws;
  for (int i = 0; i < count; ++i) yaws.push_back(NormalizeAngle(2 * M_PI * i / count));
  return yaws;
}

double LowestAltitude(const CoverageMap& coverage, const NextBestViewOptions& options) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const IsoPoint& point : coverage.points) {
    if (point.coverage != CoverageClass::kIgnored) lowest = std::min(lowest, point.position.z());
  }
  return lowest + options.min_altitude_m;
}

double LeastRatio(const ViewPlanInput& input, const NextBestViewOptions& options) {
  if (IsPlaneSweep(options)) {
    return options.paper_only ? 0 : input.coverage.min_projection_ratio;
  }
  return options.ratio_reserve * input.coverage.min_projection_ratio;
}

// Why nothing was found, from positions all around the uncovered points.
std::string Explain(const SearchContext& context, const ViewPlanResult& result) {
  if (context.pitches_rad.empty()) return "the gimbal can do none of the pitches that are tried";
  BoundingBox box;
  for (const std::size_t i : IndicesOfUncovered(context.input.coverage)) {
    box.extend(context.input.coverage.points[i].position);
  }
  const double range = UsefulRange(context);
  constexpr int kSteps = 11;
  std::map<std::string, int> reasons;
  int num_free = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Vector3d part =
        Eigen::Vector3d(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps)) / (kSteps - 1);
    const Eigen::Vector3d low = box.min().array() - range;
    const Eigen::Vector3d high = box.max().array() + range;
    Eigen::Vector3d position = low + part.cwiseProduct(high - low);
    if (position.z() < context.lowest_altitude_m) continue;
    const std::string reason = WhyNotFree(context, position);
    if (reason.empty()) {
      ++num_free;
    } else {
      ++reasons[reason];
    }
  }
  if (num_free == 0) {
    const auto most =
        std::max_element(reasons.begin(), reasons.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    return "no position around the uncovered points is free: " +
           (most == reasons.end() ? "all are below the lowest altitude"
                                  : "most are " + most->first);
  }
  if (result.reachable_uncovered == 0) {
    return "no free position sees an uncovered point at the wanted resolution (it is hidden, or "
           "every such view repeats one that there is)";
  }
  return "what could be seen is too far from existing views: none that SfM can register (nearness, "
         "min_shared_features) sees anything new";
}

// The tour over the views as they are, for strategies that have none.
void MeasureTour(const ViewPlanInput& input, const NextBestViewOptions& options,
                 ViewPlanResult* result) {
  ViewTour tour(StartOf(input), options);
  for (const PlannedView& view : result->views) tour.Insert(view.position);
  tour.Improve();
  result->tour_length_m = tour.length_m();
  result->tour_duration_s = tour.duration_s();
}

// plane_sweep scores its views itself; for the others the same sum is filled in.
void FillScores(const SearchContext& context, ViewPlanResult* result) {
  const CoverageMap& coverage = context.input.coverage;
  const UncoveredPoints points(coverage, IndicesOfUncovered(coverage), context.options);
  ParallelFor(result->views.size(), [&](std::size_t v) {
    PlannedView& view = result->views[v];
    ViewFan fan(context, {view.direction});
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!fan.LookAt(view.position, points.position(i), points.normal(i)) ||
          !context.engine.IsUnoccluded(view.position, points.position(i), points.normal(i))) {
        continue;
      }
      view.score += fan.seen().front().second;
    }
  });
}

}  // namespace

ViewPlanResult PlanNextViews(const ViewPlanInput& input, const NextBestViewOptions& options,
                             const JobControl& job) {
  ThrowIfInvalid(options.Check());
  if (input.existing.empty()) {
    throw Error("next best views: there are no registered photos to go on from");
  }
  ViewPlanResult result;
  result.uncovered = input.coverage.Count(CoverageClass::kUncovered);
  if (result.uncovered == 0) {
    result.stop_reason = "covered";
    return result;
  }
  const VisibilityEngine engine(input.surface, options.visibility);
  const SearchContext context{options,
                              input,
                              engine,
                              LeastRatio(input, options),
                              LowestAltitude(input.coverage, options),
                              Pitches(options),
                              Yaws(options)};
  std::vector<Anchor> anchors;
  for (const PosedPhoto& photo : input.existing) {
    anchors.push_back({CameraCenter(photo.cam_from_world), ViewDirectionOf(photo.cam_from_world)});
  }
  if (IsPlaneSweep(options)) {
    RunPlaneSweep(context, anchors, job, &result);
    MeasureTour(input, options, &result);
  } else {
    if (options.strategy == "submodular") {
      RunSubmodular(context, anchors, job, &result);
    } else if (options.strategy == "smith2018") {
      RunSmith2018(context, job, &result);
    } else {
      RunBaseline(context, job, &result);
    }
    FillScores(context, &result);
  }
  if (result.views.empty()) {
    result.stop_reason = "nothing_reachable";
    result.explanation = Explain(context, result);
  }
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    result.views[i].id = input.first_id + static_cast<int>(i);
  }
  return result;
}

}  // namespace colmap_ext
