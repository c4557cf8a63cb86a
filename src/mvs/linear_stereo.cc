#include "colmap_ext/mvs/linear_stereo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"
#include "mvs/facet_system.h"
#include "mvs/raster.h"

namespace colmap_ext {
namespace {

// Of what the rows say about depth itself; rows about slants (coefficients that nearly cancel) say
// nothing. 0 when none does.
double MedianInverseDepth(const std::vector<DepthRow>& rows) {
  constexpr double kLeastSum = 0.2;  // of the coefficients, in units of their norm
  std::vector<double> inverse_depths;
  for (const DepthRow& row : rows) {
    const double sum = row.barycentric.sum();
    if (!(std::abs(sum) > kLeastSum * row.barycentric.norm())) continue;
    if (row.inverse_depth / sum > 0) inverse_depths.push_back(row.inverse_depth / sum);
  }
  return inverse_depths.empty() ? 0.0 : MiddleValue(std::move(inverse_depths));
}

Eigen::Vector2d Centroid(const ImageMesh& mesh, std::size_t t) {
  const Eigen::Vector3i& corner = mesh.triangles[t];
  return (mesh.vertices_px[static_cast<std::size_t>(corner[0])] +
          mesh.vertices_px[static_cast<std::size_t>(corner[1])] +
          mesh.vertices_px[static_cast<std::size_t>(corner[2])]) /
         3.0;
}

// Distance of each triangle from the nearest one with a row, along the mesh from centroid to
// centroid. Crossing a colour edge costs up to kColorEdgePx more: regions of one colour belong
// together.
std::vector<double> DistanceToSupport(const ImageMesh& mesh, const std::vector<FacetEdge>& edges,
                                      const std::vector<DepthRow>& rows) {
  constexpr double kColorEdgePx = 25.0;
  struct Step {
    int to;
    double cost;
  };
  std::vector<std::vector<Step>> steps(mesh.triangles.size());
  for (const FacetEdge& edge : edges) {
    const auto a = static_cast<std::size_t>(edge.triangle[0]);
    const auto b = static_cast<std::size_t>(edge.triangle[1]);
    const double cost =
        (Centroid(mesh, a) - Centroid(mesh, b)).norm() + kColorEdgePx * (1.0 - edge.color_weight);
    steps[a].push_back({edge.triangle[1], cost});
    steps[b].push_back({edge.triangle[0], cost});
  }
  std::vector<double> distance(mesh.triangles.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const DepthRow& row : rows) {
    distance[static_cast<std::size_t>(row.triangle)] = 0;
    open.emplace(0.0, row.triangle);
  }
  while (!open.empty()) {
    const auto [d, t] = open.top();
    open.pop();
    if (d > distance[static_cast<std::size_t>(t)]) continue;
    for (const Step& step : steps[static_cast<std::size_t>(t)]) {
      if (d + step.cost < distance[static_cast<std::size_t>(step.to)]) {
        distance[static_cast<std::size_t>(step.to)] = d + step.cost;
        open.emplace(d + step.cost, step.to);
      }
    }
  }
  return distance;
}

}  // namespace

std::vector<std::vector<int>> PointsOfPhotos(const PhotoSet& photos) {
  std::vector<std::vector<int>> points(photos.photos.size());
  for (std::size_t p = 0; p < photos.points.size(); ++p) {
    for (const int photo : photos.points[p].photo_indices) {
      points[static_cast<std::size_t>(photo)].push_back(static_cast<int>(p));
    }
  }
  return points;
}

std::vector<DepthRow> CollectSfmRows(const PhotoSet& photos, int photo_index,
                                     const std::vector<int>& points_of_photo, const ImageMesh& mesh,
                                     const cv::Mat1i& triangle_at) {
  const PosedPhoto& photo = photos.photos[static_cast<std::size_t>(photo_index)];
  std::vector<DepthRow> rows;
  for (const int p : points_of_photo) {
    const SupportPoint& point = photos.points[static_cast<std::size_t>(p)];
    const Eigen::Vector3d point_in_cam = photo.cam_from_world * point.position;
    if (!(point_in_cam.z() > 0)) continue;
    const Eigen::Vector2d pixel = photo.camera.Project(point_in_cam);
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < triangle_at.cols &&
          pixel.y() < triangle_at.rows)) {
      continue;
    }
    DepthRow row;
    row.triangle = triangle_at(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
    if (row.triangle < 0) continue;
    const Eigen::Vector3i& corner = mesh.triangles[static_cast<std::size_t>(row.triangle)];
    row.barycentric = Barycentric(mesh.vertices_px[static_cast<std::size_t>(corner[0])],
                                  mesh.vertices_px[static_cast<std::size_t>(corner[1])],
                                  mesh.vertices_px[static_cast<std::size_t>(corner[2])], pixel);
    row.inverse_depth = 1.0 / point_in_cam.z();
    const double error_px = std::max(0.0, point.error_px);
    const double track_weight = point.photo_indices.size() > 2 ? 1.0 : 0.5;
    row.weight = track_weight / (1.0 + error_px * error_px);
    rows.push_back(row);
  }
  return rows;
}

struct LinearStereo::Impl {
  SuperpixelStereoOptions options;
  std::optional<FacetSystem> system;
  // Inverse depths divided by `scale`; weights with the robust factor.
  std::vector<DepthRow> sfm_rows;
  double scale = 0;  // median inverse depth of the SfM points; 0 without any
  ViewMesh initial;

  void SolveInitially();
};

void LinearStereo::Impl::SolveInitially() {
  // The first pass is stiff, so that a bad point shows as a residual instead of pulling its
  // triangle along; the last has the paper's weights.
  constexpr double kFirstStiffness = 20.0;
  constexpr double kResidualFloor = 1e-3;  // of the median depth
  constexpr double kCauchy = 2.385;        // 95 % efficiency for Gaussian residuals
  const std::vector<DepthRow> plain_rows = sfm_rows;
  std::vector<Eigen::Vector3d>& depth = initial.inverse_depth;
  depth.assign(depth.size(), Eigen::Vector3d::Ones());
  FacetSolver solver(*system, {});
  for (int pass = 0; pass < options.robust_passes; ++pass) {
    const bool is_last = pass + 1 == options.robust_passes;
    const double progress =
        options.robust_passes == 1 ? 1.0 : static_cast<double>(pass) / (options.robust_passes - 1);
    if (!solver.Solve(std::pow(kFirstStiffness, 1.0 - progress), sfm_rows, &depth)) {
      throw Error("superpixel stereo: the linear system of photo " +
                  std::to_string(initial.photo_index) + " cannot be factorised");
    }
    if (is_last) break;
    std::vector<double> residuals;
    for (const DepthRow& row : plain_rows) {
      residuals.push_back(std::abs(
          row.inverse_depth - row.barycentric.dot(depth[static_cast<std::size_t>(row.triangle)])));
    }
    const double sigma = std::max(kResidualFloor, 1.4826 * MiddleValue(residuals));
    for (std::size_t r = 0; r < sfm_rows.size(); ++r) {
      const double ratio = residuals[r] / (kCauchy * sigma);
      sfm_rows[r].weight = plain_rows[r].weight / (1.0 + ratio * ratio);
    }
  }
  for (Eigen::Vector3d& corners : depth) corners *= scale;
}

LinearStereo::LinearStereo(const PhotoSet& photos, int photo_index,
                           const std::vector<int>& points_of_photo, const ImageMesh& mesh,
                           const cv::Mat1i& triangle_at, const SuperpixelStereoOptions& options) {
  ThrowIfInvalid(options.Check());
  const PosedPhoto& photo = photos.photos[static_cast<std::size_t>(photo_index)];
  const auto impl = std::make_shared<Impl>();
  impl_ = impl;
  ViewMesh& view = impl->initial;
  view.photo_index = photo_index;
  view.camera = photo.camera;
  view.cam_from_world = photo.cam_from_world;
  view.image = mesh;
  view.inverse_depth.assign(mesh.triangles.size(), Eigen::Vector3d::Zero());
  view.confidence.assign(mesh.triangles.size(), 0.0F);
  view.supported.assign(mesh.triangles.size(), 0);
  impl->options = options;
  const std::vector<FacetEdge> edges = CollectEdges(mesh, options);
  impl->system.emplace(mesh.triangles.size(), edges, options.smoothness_weight,
                       options.continuity_weight);
  impl->sfm_rows = CollectSfmRows(photos, photo_index, points_of_photo, mesh, triangle_at);
  if (impl->sfm_rows.empty()) return;

  impl->scale = MedianInverseDepth(impl->sfm_rows);
  for (DepthRow& row : impl->sfm_rows) row.inverse_depth /= impl->scale;
  const std::vector<double> distance = DistanceToSupport(mesh, edges, impl->sfm_rows);
  impl->SolveInitially();
  for (std::size_t t = 0; t < distance.size(); ++t) {
    view.supported[t] =
        distance[t] <= options.max_support_px && view.inverse_depth[t].minCoeff() > 0;
  }
}

const ViewMesh& LinearStereo::initial() const { return impl_->initial; }

void LinearStereo::Refine(const std::vector<std::uint8_t>& fixed, const std::vector<DepthRow>& rows,
                          ViewMesh* mesh) const {
  Refine(fixed, rows, &mesh->inverse_depth, &mesh->supported);
}

void LinearStereo::Refine(const std::vector<std::uint8_t>& fixed, const std::vector<DepthRow>& rows,
                          std::vector<Eigen::Vector3d>* inverse_depth,
                          std::vector<std::uint8_t>* supported) const {
  double scale = impl_->scale;
  if (scale == 0) {
    scale = MedianInverseDepth(rows);
    if (!(scale > 0)) return;
  }
  std::vector<DepthRow> all_rows = impl_->sfm_rows;
  for (const DepthRow& row : rows) {
    all_rows.push_back(row);
    all_rows.back().inverse_depth /= scale;
  }
  std::vector<Eigen::Vector3d> depth = *inverse_depth;
  for (Eigen::Vector3d& corners : depth) corners /= scale;
  if (!FacetSolver(*impl_->system, fixed).Solve(1.0, all_rows, &depth)) {
    throw Error("superpixel stereo: the fusion system of photo " +
                std::to_string(impl_->initial.photo_index) + " cannot be factorised");
  }
  *supported = impl_->initial.supported;
  for (const DepthRow& row : rows) (*supported)[static_cast<std::size_t>(row.triangle)] = 1;
  for (std::size_t t = 0; t < depth.size(); ++t) {
    if (fixed[t] != 0) {
      (*supported)[t] = 1;
      continue;
    }
    (*inverse_depth)[t] = scale * depth[t];
    if (!((*inverse_depth)[t].minCoeff() > 0)) (*supported)[t] = 0;
  }
}

}  // namespace colmap_ext
