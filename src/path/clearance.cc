#include "colmap_ext/path/clearance.h"

#include <algorithm>
#include <queue>

namespace colmap_ext {
namespace {

// What the mesh's float32 copy and the float32 distance may be wrong by, at building scale.
constexpr double kRounding_m = 1e-3;

struct Piece {
  Eigen::Vector3d a, b;
  double distance_a = 0, distance_b = 0;

  double LowerBound() const { return (distance_a + distance_b - (a - b).norm()) / 2 - kRounding_m; }
  // The piece with the smallest bound is refined first.
  bool operator<(const Piece& other) const { return LowerBound() > other.LowerBound(); }
};

// Halves the piece; returns the distance at its middle.
double Halve(const RayScene& scene, const Piece& piece, double max_m, Piece* first, Piece* second) {
  const Eigen::Vector3d middle = (piece.a + piece.b) / 2;
  const double distance = scene.DistanceToSurface(middle, max_m);
  *first = {piece.a, middle, piece.distance_a, distance};
  *second = {middle, piece.b, distance, piece.distance_b};
  return distance;
}

}  // namespace

bool ProveClearance(const RayScene& scene, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double required_m, double tolerance_m) {
  const double least = required_m + tolerance_m;
  // Beyond this a distance proves the whole segment by itself.
  const double max_m = least + (a - b).norm() + 1;
  Piece whole{a, b, scene.DistanceToSurface(a, max_m), scene.DistanceToSurface(b, max_m)};
  if (whole.distance_a < least || whole.distance_b < least) return false;
  std::vector<Piece> open = {whole};
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    if (piece.LowerBound() >= required_m) continue;
    Piece first, second;
    if (Halve(scene, piece, max_m, &first, &second) < least) return false;
    open.push_back(first);
    open.push_back(second);
  }
  return true;
}

double ProvedMinClearance(const RayScene& scene, const std::vector<Eigen::Vector3d>& polyline,
                          double tolerance_m, double max_m) {
  if (polyline.empty()) return max_m;
  std::priority_queue<Piece> open;
  double least_sample = max_m;
  std::vector<double> distances;
  for (const Eigen::Vector3d& point : polyline) {
    distances.push_back(scene.DistanceToSurface(point, max_m));
    least_sample = std::min(least_sample, distances.back());
  }
  double bound = least_sample - kRounding_m;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    open.push({polyline[i], polyline[i + 1], distances[i], distances[i + 1]});
  }
  while (!open.empty()) {
    const Piece piece = open.top();
    bound = std::min(least_sample - kRounding_m, piece.LowerBound());
    if (bound >= least_sample - tolerance_m - kRounding_m) break;
    open.pop();
    Piece first, second;
    least_sample = std::min(least_sample, Halve(scene, piece, max_m, &first, &second));
    open.push(first);
    open.push(second);
  }
  return std::max(0.0, bound);
}

}  // namespace colmap_ext
