#include "colmap_ext/mvs/confidence.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

// From the camera frame of a view to that of a neighbour, and where its pixels are.
struct Witness {
  const ViewMesh* mesh;
  const ViewLookup* lookup;
  Eigen::Matrix3d rotation;  // neighbour_from_view
  Eigen::Vector3d translation;
};

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

// Adds what one neighbour says about the facet with centroid X_1 (in the view's camera) at x_1.
void AddWitness(const Witness& witness, const ViewLookup& view, const Eigen::Vector3d& point_in_cam,
                const Eigen::Vector2d& pixel, const Eigen::Vector3d& normal_in_world,
                const SuperpixelStereoOptions& options, ConfidenceCues* cues) {
  const Eigen::Vector3d point_in_other = witness.rotation * point_in_cam + witness.translation;
  if (!(point_in_other.z() > 0)) return;
  const Eigen::Vector2d pixel_in_other = witness.lookup->camera.Project(point_in_other);
  const int t = witness.lookup->TriangleAt(pixel_in_other);
  if (t < 0 || witness.mesh->supported[static_cast<std::size_t>(t)] == 0) return;
  const double inverse_depth = witness.lookup->InverseDepth(t, pixel_in_other);
  if (!(inverse_depth > 0)) return;
  const double depth_ratio = 1.0 / (inverse_depth * point_in_other.z());  // mesh there / facet
  if (depth_ratio < 1.0 - options.occlusion_tolerance) return;            // hidden behind it
  // X'_1 on the same ray of the neighbour, back into the view.
  const Eigen::Vector3d back_in_cam =
      witness.rotation.transpose() * (point_in_other * depth_ratio - witness.translation);
  constexpr double kFarPx = 1e3;
  const double position_error =
      back_in_cam.z() > 0 ? std::min(kFarPx, (view.camera.Project(back_in_cam) - pixel).norm())
                          : kFarPx;
  ++cues->witnesses;
  cues->position_px += position_error;
  cues->normal_rad +=
      AngleBetween(normal_in_world, witness.lookup->normal_in_world[static_cast<std::size_t>(t)]);
}

// The three factors of Γ: position, normal, view.
Eigen::Array3d Factors(const ConfidenceCues& cues, const SuperpixelStereoOptions& options) {
  if (cues.witnesses == 0) return Eigen::Array3d::Zero();
  const double cosine = std::cos(cues.view_rad);
  return {std::exp(-cues.position_px / options.sigma_position_px),
          std::exp(-cues.normal_rad / DegToRad(options.sigma_normal_deg)),
          1.0 - std::exp(-cosine * cosine / options.sigma_view)};
}

}  // namespace

double ConfidenceScore(const ConfidenceCues& cues, const SuperpixelStereoOptions& options) {
  return Factors(cues, options).prod();
}

DenseMap ConfidenceCueMaps(const std::vector<ConfidenceCues>& cues, const cv::Mat1i& triangle_at,
                           const SuperpixelStereoOptions& options) {
  std::vector<Eigen::Array4f> values;
  for (const ConfidenceCues& cue : cues) {
    const Eigen::Array3d factors = Factors(cue, options);
    values.emplace_back(static_cast<float>(factors[0]), static_cast<float>(factors[1]),
                        static_cast<float>(factors[2]), static_cast<float>(factors.prod()));
  }
  DenseMap maps(triangle_at.cols, triangle_at.rows, 4);
  for (int y = 0; y < triangle_at.rows; ++y) {
    for (int x = 0; x < triangle_at.cols; ++x) {
      const int t = triangle_at(y, x);
      if (t < 0) continue;
      for (int c = 0; c < 4; ++c) maps.At(y, x, c) = values[static_cast<std::size_t>(t)][c];
    }
  }
  return maps;
}

std::vector<ConfidenceCues> EvaluateCues(const std::vector<ViewMesh>& views,
                                         const std::vector<ViewLookup>& lookups,
                                         const std::vector<int>& neighbors_of_view, int view,
                                         const SuperpixelStereoOptions& options) {
  const ViewMesh& mesh = views[static_cast<std::size_t>(view)];
  const ViewLookup& lookup = lookups[static_cast<std::size_t>(view)];
  std::vector<Witness> witnesses;
  for (const int j : neighbors_of_view) {
    const ViewLookup& other = lookups[static_cast<std::size_t>(j)];
    const Rigid3d other_from_view = other.cam_from_world * lookup.world_from_cam;
    witnesses.push_back({&views[static_cast<std::size_t>(j)], &other,
                         other_from_view.rotation.toRotationMatrix(), other_from_view.translation});
  }
  struct Facet {
    std::size_t t;
    Eigen::Vector2d pixel;  // of its centroid
    Eigen::Vector3d point_in_cam;
  };
  std::vector<ConfidenceCues> cues(mesh.image.triangles.size());
  std::vector<Facet> facets;
  facets.reserve(cues.size());
  for (std::size_t t = 0; t < cues.size(); ++t) {
    if (mesh.supported[t] == 0) continue;
    const Eigen::Vector3i& corner = mesh.image.triangles[t];
    const Eigen::Vector2d pixel = (mesh.image.vertices_px[static_cast<std::size_t>(corner[0])] +
                                   mesh.image.vertices_px[static_cast<std::size_t>(corner[1])] +
                                   mesh.image.vertices_px[static_cast<std::size_t>(corner[2])]) /
                                  3.0;
    const Eigen::Vector3d ray = lookup.camera.Ray(pixel);
    facets.push_back({t, pixel, ray / lookup.plane_in_cam[t].dot(ray)});
    cues[t].view_rad = AngleBetween(lookup.plane_in_cam[t].normalized(), ray.normalized());
  }
  // Neighbour by neighbour: what adjacent facets look up in one lies together in memory.
  for (const Witness& witness : witnesses) {
    for (const Facet& facet : facets) {
      AddWitness(witness, lookup, facet.point_in_cam, facet.pixel, lookup.normal_in_world[facet.t],
                 options, &cues[facet.t]);
    }
  }
  for (ConfidenceCues& cue : cues) {
    if (cue.witnesses == 0) continue;
    cue.position_px /= cue.witnesses;
    cue.normal_rad /= cue.witnesses;
  }
  return cues;
}

void EvaluateConfidence(const std::vector<ViewLookup>& lookups,
                        const std::vector<std::vector<int>>& neighbors,
                        const std::vector<std::size_t>& which,
                        const SuperpixelStereoOptions& options, std::vector<ViewMesh>* views) {
  ParallelFor(which.size(), [&](std::size_t k) {
    const std::size_t i = which[k];
    const std::vector<ConfidenceCues> cues =
        EvaluateCues(*views, lookups, neighbors[i], static_cast<int>(i), options);
    std::vector<float>& confidence = (*views)[i].confidence;
    for (std::size_t t = 0; t < cues.size(); ++t) {
      confidence[t] = static_cast<float>(ConfidenceScore(cues[t], options));
    }
  });
}

}  // namespace colmap_ext
