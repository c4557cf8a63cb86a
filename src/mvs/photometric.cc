#include "colmap_ext/mvs/photometric.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/util/parallel.h"
#include "mvs/photo_patch.h"
#include "mvs/plane_search.h"

namespace colmap_ext {
namespace {

std::vector<PixelTransfer> MakeTransfers(const std::vector<ViewLookup>& lookups,
                                         const std::vector<cv::Mat1i>& grey,
                                         const std::vector<int>& neighbors, std::size_t view) {
  std::vector<PixelTransfer> transfers;
  for (const int j : neighbors) {
    transfers.emplace_back(lookups[view], lookups[static_cast<std::size_t>(j)],
                           grey[static_cast<std::size_t>(j)]);
  }
  return transfers;
}

// Facets of a neighbour, as hypotheses where their centroids fall in the view.
void AddFacetsOfNeighbor(const ViewMesh& mesh, const ViewLookup& lookup, const ViewMesh& other,
                         const ViewLookup& other_lookup, PlaneSearch* search) {
  constexpr float kLeastConfidence = 0.3F;
  const Rigid3d other_from_view = other_lookup.cam_from_world * lookup.world_from_cam;
  const Rigid3d view_from_other = Inverse(other_from_view);
  const Eigen::Matrix3d rotation = other_from_view.rotation.toRotationMatrix();
  for (std::size_t t = 0; t < other.image.triangles.size(); ++t) {
    if (other.supported[t] == 0 || other.confidence[t] < kLeastConfidence) continue;
    const Eigen::Vector3d& plane = other_lookup.plane_in_cam[t];
    const double side = 1.0 - plane.dot(other_from_view.translation);
    if (!(side > 0)) continue;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) {
      pixel += other.image.vertices_px[static_cast<std::size_t>(other.image.triangles[t][k])] / 3.0;
    }
    const Eigen::Vector3d ray = other.camera.Ray(pixel);
    const Eigen::Vector3d point_in_view = view_from_other * (ray / plane.dot(ray));
    if (!(point_in_view.z() > 0)) continue;
    const int target = lookup.TriangleAt(mesh.camera.Project(point_in_view));
    if (target < 0) continue;
    search->AddHypothesis(mesh.image.superpixel[static_cast<std::size_t>(target)],
                          rotation.transpose() * plane / side);
  }
}

// Planes through the SfM points that the photo observes, for the superpixels around them: parallel
// to the facet that is there, and facing the camera.
void AddPoints(const PhotoSet& photos, const std::vector<int>& points, const ViewMesh& mesh,
               const ViewLookup& lookup, PlaneSearch* search) {
  constexpr int kReachPx = 20;
  for (const int p : points) {
    const Eigen::Vector3d in_cam =
        mesh.cam_from_world * photos.points[static_cast<std::size_t>(p)].position;
    if (!(in_cam.z() > 0)) continue;
    const Eigen::Vector2d pixel = mesh.camera.Project(in_cam);
    for (int dy = -kReachPx; dy <= kReachPx; dy += kReachPx) {
      for (int dx = -kReachPx; dx <= kReachPx; dx += kReachPx) {
        const int t = lookup.TriangleAt(pixel + Eigen::Vector2d(dx, dy));
        if (t < 0) continue;
        const int superpixel = mesh.image.superpixel[static_cast<std::size_t>(t)];
        search->AddHypothesis(superpixel, {0, 0, 1.0 / in_cam.z()});
        if (mesh.supported[static_cast<std::size_t>(t)] == 0) continue;
        const Eigen::Vector3d& plane = lookup.plane_in_cam[static_cast<std::size_t>(t)];
        const double scale = plane.dot(in_cam);
        if (scale > 0) search->AddHypothesis(superpixel, plane / scale);
      }
    }
  }
}

}  // namespace

double PhotoConsistency(const PhotoCue& cue, const SuperpixelStereoOptions& options) {
  constexpr double kLeastDeviation = 3.0;  // grey levels
  constexpr double kFreeError = 0.1;
  if (cue.witnesses == 0 || cue.deviation < kLeastDeviation) return 1.0;
  const double variance = static_cast<double>(cue.deviation) * cue.deviation;
  const double expected = variance / (variance + PhotoPatch::kNoiseVariance);
  const double error = 1.0 - cue.correlation / expected;
  return std::exp(-std::max(0.0, error - kFreeError) / options.sigma_photometric);
}

PhotometricStage::PhotometricStage(const PhotoSet& photos,
                                   const std::vector<std::vector<int>>& neighbors,
                                   const SuperpixelStereoOptions& options)
    : photos_(photos),
      neighbors_(neighbors),
      options_(options),
      grey_(photos.photos.size()),
      points_of_photo_(PointsOfPhotos(photos)) {
  ParallelFor(grey_.size(), [&](std::size_t i) {
    if (!photos.photos[i].bgr.empty()) grey_[i] = PackGrey(photos.photos[i].bgr);
  });
}

std::vector<DepthRow> PhotometricStage::CollectRows(const std::vector<ViewMesh>& views,
                                                    const std::vector<ViewLookup>& lookups,
                                                    int view) const {
  const auto i = static_cast<std::size_t>(view);
  PlaneSearch search(views[i], lookups[i], grey_[i],
                     MakeTransfers(lookups, grey_, neighbors_[i], i), options_);
  for (const int j : neighbors_[i]) {
    AddFacetsOfNeighbor(views[i], lookups[i], views[static_cast<std::size_t>(j)],
                        lookups[static_cast<std::size_t>(j)], &search);
  }
  AddPoints(photos_, points_of_photo_[i], views[i], lookups[i], &search);
  search.ScorePresentPlanes();
  search.TryHypotheses();
  return search.RefineAndCollectRows();
}

void PhotometricStage::EvaluateCues(const std::vector<ViewMesh>& views,
                                    const std::vector<ViewLookup>& lookups, int view,
                                    const std::vector<std::uint8_t>& keep,
                                    std::vector<PhotoCue>* cues) const {
  const auto i = static_cast<std::size_t>(view);
  const ViewMesh& mesh = views[i];
  const std::vector<PixelTransfer> transfers = MakeTransfers(lookups, grey_, neighbors_[i], i);
  cues->resize(mesh.image.triangles.size());
  for (std::size_t t = 0; t < cues->size(); ++t) {
    if (!keep.empty() && keep[t] != 0) continue;
    (*cues)[t] = {};
    if (mesh.supported[t] == 0) continue;
    const PhotoPatch patch = MakePatch(mesh, lookups[i].triangle_at, grey_[i], static_cast<int>(t),
                                       options_.color_sigma);
    const PatchScore score =
        ScorePlane(patch, ToPatchPlane(lookups[i].plane_in_cam[t], mesh.camera, patch), transfers);
    (*cues)[t] = {score.witnesses, score.best, std::sqrt(patch.variance)};
  }
}

}  // namespace colmap_ext
