#include "colmap_ext/sfm/pairing.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

PhotoPair Ordered(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

bool AxesAgree(const PhotoPlace& a, const PhotoPlace& b, double min_cosine) {
  if (!a.optical_axis || !b.optical_axis) return true;
  return a.optical_axis->dot(*b.optical_axis) >= min_cosine;
}

// Neighbours of photo `i` among those with a position: all within the radius up to max_neighbors,
// and never fewer than min_neighbors.
std::vector<int> NearestPhotos(const std::vector<PhotoPlace>& places, int i, double min_cosine,
                               const PairingOptions& options) {
  const PhotoPlace& place = places[static_cast<std::size_t>(i)];
  std::vector<std::pair<double, int>> by_distance;
  for (int j = 0; j < static_cast<int>(places.size()); ++j) {
    const PhotoPlace& other = places[static_cast<std::size_t>(j)];
    if (j == i || !other.position_m || !AxesAgree(place, other, min_cosine)) continue;
    by_distance.emplace_back((*other.position_m - *place.position_m).norm(), j);
  }
  const auto wanted = std::min(by_distance.size(), static_cast<std::size_t>(options.max_neighbors));
  std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(wanted),
                    by_distance.end());
  std::vector<int> neighbors;
  for (std::size_t k = 0; k < wanted; ++k) {
    const bool near = by_distance[k].first <= options.max_distance_m;
    if (near || k < static_cast<std::size_t>(options.min_neighbors)) {
      neighbors.push_back(by_distance[k].second);
    }
  }
  return neighbors;
}

// Partners of a photo without position, by its place in the name order.
std::vector<int> SequentialPhotos(int count, int i, const PairingOptions& options) {
  std::vector<int> partners;
  if (count <= options.exhaustive_limit) {
    for (int j = 0; j < count; ++j) {
      if (j != i) partners.push_back(j);
    }
    return partners;
  }
  std::set<int> offsets;
  for (int offset = 1; offset <= options.sequential_overlap; ++offset) offsets.insert(offset);
  for (int offset = 1; offset < count; offset *= 2) offsets.insert(offset);
  for (const int offset : offsets) {
    if (i - offset >= 0) partners.push_back(i - offset);
    if (i + offset < count) partners.push_back(i + offset);
  }
  return partners;
}

}  // namespace

std::string PairingOptions::Check() const {
  if (!(max_distance_m > 0)) return "Pairing.max_distance_m must be above 0 m";
  if (min_neighbors < 1) return "Pairing.min_neighbors must be at least 1";
  if (max_neighbors < min_neighbors) {
    return "Pairing.max_neighbors must not be below Pairing.min_neighbors";
  }
  if (!(max_axis_angle_deg > 0 && max_axis_angle_deg <= 180)) {
    return "Pairing.max_axis_angle_deg must be above 0 and at most 180 degrees";
  }
  if (exhaustive_limit < 2) return "Pairing.exhaustive_limit must be at least 2";
  if (sequential_overlap < 1) return "Pairing.sequential_overlap must be at least 1";
  return "";
}

void BindOptions(OptionSet& set, PairingOptions* options) {
  set.Add("Pairing", "max_distance_m", &options->max_distance_m,
          "match photos nearer than this (m, > 0)");
  set.Add("Pairing", "min_neighbors", &options->min_neighbors,
          "match every photo with at least so many nearest ones (>= 1)");
  set.Add("Pairing", "max_neighbors", &options->max_neighbors,
          "... and with at most so many inside the distance (>= min_neighbors)");
  set.Add("Pairing", "max_axis_angle_deg", &options->max_axis_angle_deg,
          "skip pairs whose optical axes, when known, differ by more (deg, 0 < a <= 180)");
  set.Add("Pairing", "exhaustive_limit", &options->exhaustive_limit,
          "photos without position: match all pairs up to so many photos (>= 2)");
  set.Add("Pairing", "sequential_overlap", &options->sequential_overlap,
          "... and beyond it so many next ones in name order (>= 1)");
}

std::vector<PhotoPair> ChoosePairs(const std::vector<PhotoPlace>& places,
                                   const std::vector<bool>& is_new,
                                   const std::set<PhotoPair>& existing,
                                   const PairingOptions& options) {
  ThrowIfInvalid(options.Check());
  const int count = static_cast<int>(places.size());
  const double min_cosine = std::cos(DegToRad(options.max_axis_angle_deg));
  std::set<PhotoPair> pairs;
  for (int i = 0; i < count; ++i) {
    const std::vector<int> partners = places[static_cast<std::size_t>(i)].position_m
                                          ? NearestPhotos(places, i, min_cosine, options)
                                          : SequentialPhotos(count, i, options);
    for (const int j : partners) {
      if (!is_new[static_cast<std::size_t>(i)] && !is_new[static_cast<std::size_t>(j)]) continue;
      const PhotoPair pair = Ordered(i, j);
      if (existing.count(pair) == 0) pairs.insert(pair);
    }
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace colmap_ext
