#include "colmap_ext/mvs/points.h"

#include <algorithm>
#include <memory>

#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

struct Sample {
  Eigen::Vector2d pixel;
  int triangle;
};

// Grid pixels on facets that may give points, then the centroids of such facets without one.
std::vector<Sample> PlaceSamples(const ViewMesh& mesh, const ViewLookup& lookup,
                                 const PointSamplerOptions& options) {
  std::vector<std::uint8_t> wanted(mesh.image.triangles.size());
  for (std::size_t t = 0; t < wanted.size(); ++t) {
    wanted[t] = mesh.supported[t] != 0 && mesh.confidence[t] > options.min_confidence;
  }
  std::vector<Sample> samples;
  std::vector<std::uint8_t> missing = wanted;
  for (int y = options.step_px / 2; y < lookup.triangle_at.rows; y += options.step_px) {
    for (int x = options.step_px / 2; x < lookup.triangle_at.cols; x += options.step_px) {
      const int t = lookup.triangle_at(y, x);
      if (t < 0 || wanted[static_cast<std::size_t>(t)] == 0) continue;
      samples.push_back({{x + 0.5, y + 0.5}, t});
      missing[static_cast<std::size_t>(t)] = 0;
    }
  }
  for (std::size_t t = 0; t < missing.size(); ++t) {
    if (missing[t] == 0) continue;
    Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) {
      centroid += mesh.image.vertices_px[static_cast<std::size_t>(mesh.image.triangles[t][k])] / 3;
    }
    samples.push_back({centroid, static_cast<int>(t)});
  }
  return samples;
}

// Whether confident facets of the neighbours contradict the point: their camera looks through it.
bool IsInFreeSpace(const Eigen::Vector3d& point, const std::vector<ViewMesh>& views,
                   const std::vector<std::unique_ptr<ViewLookup>>& lookups,
                   const std::vector<int>& neighbors, const PointSamplerOptions& options) {
  int against = 0;
  int in_favour = 0;
  for (const int j : neighbors) {
    const ViewLookup& other = *lookups[static_cast<std::size_t>(j)];
    const Eigen::Vector3d in_cam = other.cam_from_world * point;
    if (!(in_cam.z() > 0)) continue;
    const Eigen::Vector2d pixel = other.camera.Project(in_cam);
    const int t = other.TriangleAt(pixel);
    if (t < 0) continue;
    const ViewMesh& mesh = views[static_cast<std::size_t>(j)];
    if (mesh.supported[static_cast<std::size_t>(t)] == 0 ||
        !(mesh.confidence[static_cast<std::size_t>(t)] > options.min_confidence)) {
      continue;
    }
    const double share = 1.0 / (other.InverseDepth(t, pixel) * in_cam.z()) - 1.0;
    if (share > options.free_space_tolerance) {
      ++against;
    } else if (share > -options.free_space_tolerance) {
      ++in_favour;
    }
  }
  return against > in_favour;
}

OrientedPoint MakePoint(const Sample& sample, const PosedPhoto& photo, const ViewMesh& mesh,
                        const ViewLookup& lookup) {
  const auto t = static_cast<std::size_t>(sample.triangle);
  OrientedPoint point;
  point.position = lookup.PointInWorld(sample.triangle, sample.pixel);
  point.normal = lookup.normal_in_world[t];
  point.confidence = mesh.confidence[t];
  point.photo_index = mesh.photo_index;
  const int x = std::clamp(static_cast<int>(sample.pixel.x()), 0, mesh.camera.width - 1);
  const int y = std::clamp(static_cast<int>(sample.pixel.y()), 0, mesh.camera.height - 1);
  for (int c = 0; c < 3; ++c) {  // BGR to RGB
    point.color[2 - c] = photo.bgr.empty()
                             ? cv::saturate_cast<std::uint8_t>(mesh.image.mean_bgr[t][c])
                             : photo.bgr.at<cv::Vec3b>(y, x)[c];
  }
  return point;
}

}  // namespace

OrientedPoints SamplePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const PointSamplerOptions& options) {
  ThrowIfInvalid(options.Check());
  const std::vector<std::vector<int>> neighbors = FindNeighbors(photos, {});
  std::vector<std::unique_ptr<ViewLookup>> lookups(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    lookups[i] = std::make_unique<ViewLookup>(views[i], TriangleIdMap(views[i]));
  });
  std::vector<OrientedPoints> points_of_view(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    for (const Sample& sample : PlaceSamples(views[i], *lookups[i], options)) {
      const OrientedPoint point = MakePoint(sample, photos.photos[i], views[i], *lookups[i]);
      if (!IsInFreeSpace(point.position, views, lookups, neighbors[i], options)) {
        points_of_view[i].push_back(point);
      }
    }
  });
  OrientedPoints points;
  for (const OrientedPoints& part : points_of_view) {
    points.insert(points.end(), part.begin(), part.end());
  }
  return points;
}

}  // namespace colmap_ext
