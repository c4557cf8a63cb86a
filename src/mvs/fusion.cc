#include "colmap_ext/mvs/fusion.h"

#include <algorithm>
#include <cmath>

#include "mvs/raster.h"

namespace colmap_ext {
namespace {

// A facet of a neighbour covers a grid pixel of the view.
struct Hit {
  int triangle;  // of the view
  float x, y;    // pixel
  double inverse_depth;
  double weight;
};

bool IsFree(const ViewMesh& mesh, std::size_t t, const SuperpixelStereoOptions& options) {
  return !(mesh.confidence[t] > options.fixed_confidence);
}

// The corners of a facet of `other`, as pixels of the view; false when one is behind its camera.
bool ProjectCorners(const ViewMesh& other, std::size_t t, const Rigid3d& view_from_other,
                    const PinholeCamera& camera, Eigen::Vector2d corners[3]) {
  for (int k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(other.image.triangles[t][k]);
    const double inverse_depth = other.inverse_depth[t][k];
    if (!(inverse_depth > 0)) return false;
    const Eigen::Vector3d point_in_view =
        view_from_other * (other.camera.Ray(other.image.vertices_px[v]) / inverse_depth);
    if (!(point_in_view.z() > 0)) return false;
    corners[k] = camera.Project(point_in_view);
  }
  return true;
}

// Confidence of the neighbour's facet, times the proximity of colours.
double PairWeight(const ViewMesh& mesh, std::size_t t, const ViewMesh& other, std::size_t t_other,
                  const SuperpixelStereoOptions& options) {
  const double difference =
      (mesh.image.mean_bgr[t] - other.image.mean_bgr[t_other]).norm() / std::sqrt(3.0);
  const double ratio = difference / options.fusion_color_sigma;
  return other.confidence[t_other] * std::exp(-0.5 * ratio * ratio);
}

void CollectHits(const ViewMesh& mesh, const ViewLookup& lookup, const ViewMesh& other,
                 const ViewLookup& other_lookup, const SuperpixelStereoOptions& options,
                 std::vector<Hit>* hits) {
  constexpr double kMinFacing = 0.1;  // cosine between normal and ray, in the view
  const Rigid3d other_from_view = other_lookup.cam_from_world * lookup.world_from_cam;
  const Rigid3d view_from_other = Inverse(other_from_view);
  const Eigen::Matrix3d rotation = other_from_view.rotation.toRotationMatrix();
  for (std::size_t t = 0; t < other.image.triangles.size(); ++t) {
    if (IsFree(other, t, options)) continue;
    // plane · X = 1 in the neighbour; the view's camera must be on the same side of it.
    const Eigen::Vector3d& plane = other_lookup.plane_in_cam[t];
    const double side = 1.0 - plane.dot(other_from_view.translation);
    if (!(side > 0)) continue;
    const Eigen::Vector3d plane_in_view = rotation.transpose() * plane / side;
    Eigen::Vector2d corners[3];
    if (!ProjectCorners(other, t, view_from_other, lookup.camera, corners)) continue;
    const Eigen::Vector3d ray =
        lookup.camera.Ray((corners[0] + corners[1] + corners[2]) / 3.0).normalized();
    const double facing = plane_in_view.normalized().dot(ray);
    if (facing < kMinFacing) continue;
    ForEachPixelInTriangle(
        corners[0], corners[1], corners[2], lookup.camera.width, lookup.camera.height,
        options.fusion_step_px, [&](int x, int y) {
          const int id = lookup.triangle_at(y, x);
          if (id < 0 || !IsFree(mesh, static_cast<std::size_t>(id), options)) return;
          const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
          const double inverse_depth = plane_in_view.dot(lookup.camera.Ray(pixel));
          const double weight =
              facing * PairWeight(mesh, static_cast<std::size_t>(id), other, t, options);
          if (!(inverse_depth > 0) || weight < 1e-3) return;
          hits->push_back({id, static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
                           inverse_depth, weight});
        });
  }
}

// The hits of one triangle, sorted from far to near: the range that the facet should follow.
std::pair<std::size_t, std::size_t> ChooseAgreement(const std::vector<Hit>& hits, std::size_t begin,
                                                    std::size_t end, double tolerance) {
  constexpr double kNearPreference = 0.4;  // a nearer group needs this share of the strongest
  struct Group {
    std::size_t first, last;
    double weight;
  };
  std::vector<Group> groups;
  std::size_t last = begin;
  double weight = 0;
  double strongest = 0;
  for (std::size_t first = begin; first < end; ++first) {
    while (last < end &&
           hits[last].inverse_depth <= hits[first].inverse_depth * (1.0 + 2.0 * tolerance)) {
      weight += hits[last].weight;
      ++last;
    }
    groups.push_back({first, last, weight});
    strongest = std::max(strongest, weight);
    weight -= hits[first].weight;
  }
  // The nearest group that is strong enough, then the strongest of those that overlap it.
  const Group* chosen = nullptr;
  for (auto group = groups.rbegin(); group != groups.rend(); ++group) {
    if (chosen == nullptr) {
      if (group->weight >= kNearPreference * strongest) chosen = &*group;
    } else if (group->last <= chosen->first) {
      break;
    } else if (group->weight > chosen->weight) {
      chosen = &*group;
    }
  }
  return {chosen->first, chosen->last};
}

}  // namespace

std::vector<DepthRow> CollectFusionRows(const std::vector<ViewMesh>& views,
                                        const std::vector<ViewLookup>& lookups,
                                        const std::vector<int>& neighbors_of_view, int view,
                                        const SuperpixelStereoOptions& options) {
  const ViewMesh& mesh = views[static_cast<std::size_t>(view)];
  std::vector<Hit> hits;
  hits.reserve(static_cast<std::size_t>(2 * mesh.camera.width * mesh.camera.height) /
               static_cast<std::size_t>(options.fusion_step_px * options.fusion_step_px));
  for (const int j : neighbors_of_view) {
    CollectHits(mesh, lookups[static_cast<std::size_t>(view)], views[static_cast<std::size_t>(j)],
                lookups[static_cast<std::size_t>(j)], options, &hits);
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.triangle != b.triangle ? a.triangle < b.triangle : a.inverse_depth < b.inverse_depth;
  });
  std::vector<DepthRow> rows;
  for (std::size_t begin = 0; begin < hits.size();) {
    std::size_t end = begin;
    while (end < hits.size() && hits[end].triangle == hits[begin].triangle) ++end;
    const auto [first, last] = ChooseAgreement(hits, begin, end, options.fusion_space_tolerance);
    double total = 0;
    for (std::size_t h = first; h < last; ++h) total += hits[h].weight;
    const Eigen::Vector3i& corner =
        mesh.image.triangles[static_cast<std::size_t>(hits[begin].triangle)];
    for (std::size_t h = first; h < last; ++h) {
      DepthRow row;
      row.triangle = hits[h].triangle;
      row.barycentric = Barycentric(mesh.image.vertices_px[static_cast<std::size_t>(corner[0])],
                                    mesh.image.vertices_px[static_cast<std::size_t>(corner[1])],
                                    mesh.image.vertices_px[static_cast<std::size_t>(corner[2])],
                                    {hits[h].x, hits[h].y});
      row.inverse_depth = hits[h].inverse_depth;
      // However many hits, a facet's rows together weigh no more than λ_u.
      row.weight = options.fusion_weight * hits[h].weight / std::max(1.0, total);
      rows.push_back(row);
    }
    begin = end;
  }
  return rows;
}

FacetDepths FuseView(const LinearStereo& solver, const std::vector<ViewMesh>& views,
                     const std::vector<ViewLookup>& lookups,
                     const std::vector<int>& neighbors_of_view,
                     const std::vector<DepthRow>& extra_rows, int view,
                     const SuperpixelStereoOptions& options) {
  const ViewMesh& mesh = views[static_cast<std::size_t>(view)];
  std::vector<DepthRow> rows = CollectFusionRows(views, lookups, neighbors_of_view, view, options);
  rows.insert(rows.end(), extra_rows.begin(), extra_rows.end());
  std::vector<std::uint8_t> fixed;
  for (std::size_t t = 0; t < mesh.image.triangles.size(); ++t) {
    fixed.push_back(IsFree(mesh, t, options) ? 0 : 1);
  }
  FacetDepths refined{mesh.inverse_depth, mesh.supported};
  solver.Refine(fixed, rows, &refined.inverse_depth, &refined.supported);
  return refined;
}

double MovedShare(const std::vector<Eigen::Vector3d>& before,
                  const std::vector<Eigen::Vector3d>& after, double tolerance) {
  if (before.empty()) return 0;
  std::size_t moved = 0;
  for (std::size_t t = 0; t < before.size(); ++t) {
    moved += ((after[t] - before[t]).array().abs() > tolerance * before[t].array().abs()).any();
  }
  return static_cast<double>(moved) / static_cast<double>(before.size());
}

}  // namespace colmap_ext
