#include <algorithm>
#include <cmath>
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
          !overlap_.IsEnough(view.position, view.direction, &sights_[view.place]) ||
          !MayReach(context_, view.position)) {
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

// Evenly spread over a hemisphere (Fibonacci's lattice) around the middle of the points' base,
// looking at it; so far off that a point half-way out is still seen at γ_min. Those that are free,
// and that the gimbal can take.
std::vector<PoolView> HemispherePool(const SearchContext& context, const UncoveredPoints& points) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < points.size(); ++i) box.extend(points.position(i));
  Eigen::Vector3d middle = box.center();
  middle.z() = box.min().z();
  const double extent_m = (box.max() - middle).norm();
  const double radius_m = std::max(extent_m + context.options.safe_distance_m,
                                   extent_m / 2 + 0.7 * UsefulRange(context));
  const auto count = static_cast<std::size_t>(context.options.num_positions);
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<PoolView> pool;
  for (std::size_t i = 0; i < count; ++i) {
    const double up = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double around = kGoldenAngle * static_cast<double>(i);
    const double out = std::sqrt(1 - up * up);
    const Eigen::Vector3d toward(out * std::cos(around), out * std::sin(around), up);
    const Eigen::Vector3d position = middle + radius_m * toward;
    const double pitch_deg = -RadToDeg(std::asin(up));
    if (pitch_deg < context.options.min_gimbal_pitch_deg ||
        pitch_deg > context.options.max_gimbal_pitch_deg || !IsFreePosition(context, position)) {
      continue;
    }
    PoolView view = EvaluateView(context, points, position,
                                 {std::atan2(-toward.x(), -toward.y()), DegToRad(pitch_deg)});
    view.place = static_cast<std::uint32_t>(pool.size());
    pool.push_back(std::move(view));
  }
  return pool;
}

}  // namespace

void RunBaseline(const SearchContext& context, const JobControl& job, ViewPlanResult* result) {
  const NextBestViewOptions& options = context.options;
  const CoverageMap& coverage = context.input.coverage;
  // Blind: all that is to be covered counts, whatever is covered already.
  const UncoveredPoints points(
      coverage, Strided(IndicesOfWanted(coverage), static_cast<std::size_t>(options.num_points)),
      options);
  const bool is_hemisphere = options.strategy == "hemisphere";
  const std::vector<PoolView> pool =
      is_hemisphere ? HemispherePool(context, points) : BuildViewPool(context, points).views;
  result->reachable_uncovered = PartSeen(pool, points.size(), result->uncovered);
  // Another order in each iteration of a session.
  const std::vector<std::size_t> order =
      RandomOrder(pool.size(), options.seed * 1000003 + context.input.existing.size());
  Picker picker(context, pool);
  for (int i = 0; i < options.num_views; ++i) {
    job.ThrowIfCancelled();
    if (!picker.PickOne(order, options.strategy != "random")) break;
  }
  picker.Take(result);
}

}  // namespace colmap_ext
