#include "colmap_ext/mvs/points.h"

#include <algorithm>
#include <memory>

#include "colmap_ext/mvs/stereo_memory.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "mvs/memory_keys.h"

namespace colmap_ext {
namespace {

// Grid pixels on facets that may give points, then the centroids of such facets without one.
std::vector<PointSample> PlaceSamples(const ViewMesh& mesh, const ViewLookup& lookup,
                                      const PointSamplerOptions& options) {
  std::vector<std::uint8_t> wanted(mesh.image.triangles.size());
  for (std::size_t t = 0; t < wanted.size(); ++t) {
    wanted[t] = mesh.supported[t] != 0 && mesh.confidence[t] > options.min_confidence;
  }
  std::vector<PointSample> samples;
  std::vector<std::uint8_t> missing = wanted;
  for (int y = options.step_px / 2; y < lookup.triangle_at.rows; y += options.step_px) {
    for (int x = options.step_px / 2; x < lookup.triangle_at.cols; x += options.step_px) {
      const int t = lookup.triangle_at(y, x);
      if (t < 0 || wanted[static_cast<std::size_t>(t)] == 0) continue;
      samples.push_back({{x + 0.5, y + 0.5}, t, {}});
      missing[static_cast<std::size_t>(t)] = 0;
    }
  }
  for (std::size_t t = 0; t < missing.size(); ++t) {
    if (missing[t] == 0) continue;
    Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) {
      centroid += mesh.image.vertices_px[static_cast<std::size_t>(mesh.image.triangles[t][k])] / 3;
    }
    samples.push_back({centroid, static_cast<int>(t), {}});
  }
  return samples;
}

// Whether confident facets of the neighbours contradict the point: their camera looks through it.
bool IsInFreeSpace(const Eigen::Vector3d& point, const std::vector<ViewMesh>& views,
                   const std::vector<ViewLookup>& lookups, const std::vector<int>& neighbors,
                   const PointSamplerOptions& options) {
  int against = 0;
  int in_favour = 0;
  for (const int j : neighbors) {
    const ViewLookup& other = lookups[static_cast<std::size_t>(j)];
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

std::array<std::uint8_t, 3> ColorAt(const PointSample& sample, const PosedPhoto& photo,
                                    const ViewMesh& mesh) {
  const int x = std::clamp(static_cast<int>(sample.pixel.x()), 0, mesh.camera.width - 1);
  const int y = std::clamp(static_cast<int>(sample.pixel.y()), 0, mesh.camera.height - 1);
  const Eigen::Vector3f& mean_bgr = mesh.image.mean_bgr[static_cast<std::size_t>(sample.triangle)];
  std::array<std::uint8_t, 3> rgb{};
  for (int c = 0; c < 3; ++c) {
    rgb[static_cast<std::size_t>(2 - c)] = photo.bgr.empty()
                                               ? cv::saturate_cast<std::uint8_t>(mean_bgr[c])
                                               : photo.bgr.at<cv::Vec3b>(y, x)[c];
  }
  return rgb;
}

OrientedPoint MakePoint(const PointSample& sample, const ViewMesh& mesh, const ViewLookup& lookup) {
  const auto t = static_cast<std::size_t>(sample.triangle);
  OrientedPoint point;
  point.position = lookup.PointInWorld(sample.triangle, sample.pixel);
  point.normal = lookup.normal_in_world[t];
  point.confidence = mesh.confidence[t];
  point.photo_index = mesh.photo_index;
  point.color = {sample.color[0], sample.color[1], sample.color[2]};
  return point;
}

// The lookups of all views; only those that something is looked up in (`sampled` views and their
// neighbours) know the triangle of a pixel.
std::vector<ViewLookup> MakeLookups(const std::vector<ViewMesh>& views,
                                    const std::vector<std::vector<int>>& neighbors,
                                    const std::vector<std::uint8_t>& sampled) {
  std::vector<std::uint8_t> used = sampled;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (sampled[i] == 0) continue;
    for (const int j : neighbors[i]) used[static_cast<std::size_t>(j)] = 1;
  }
  std::vector<ViewLookup> lookups(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    lookups[i] = ViewLookup(views[i], used[i] != 0 ? TriangleIdMap(views[i]) : cv::Mat1i());
  });
  return lookups;
}

// Samples views[i] anew where sampled[i] != 0; all points of all samples.
OrientedPoints SampleSome(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                          const std::vector<std::vector<int>>& neighbors,
                          const PointSamplerOptions& options,
                          const std::vector<std::uint8_t>& sampled,
                          std::vector<std::vector<PointSample>>* samples) {
  const std::vector<ViewLookup> lookups = MakeLookups(views, neighbors, sampled);
  ParallelFor(views.size(), [&](std::size_t i) {
    if (sampled[i] == 0) return;
    std::vector<PointSample>& kept = (*samples)[i];
    kept = PlaceSamples(views[i], lookups[i], options);
    std::erase_if(kept, [&](const PointSample& sample) {
      return IsInFreeSpace(lookups[i].PointInWorld(sample.triangle, sample.pixel), views, lookups,
                           neighbors[i], options);
    });
    for (PointSample& sample : kept) sample.color = ColorAt(sample, photos.photos[i], views[i]);
  });
  std::vector<std::size_t> begin(views.size() + 1);  // of each view's points
  for (std::size_t i = 0; i < views.size(); ++i) begin[i + 1] = begin[i] + (*samples)[i].size();
  OrientedPoints points(begin.back());
  ParallelFor(views.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < (*samples)[i].size(); ++k) {
      points[begin[i] + k] = MakePoint((*samples)[i][k], views[i], lookups[i]);
    }
  });
  return points;
}

}  // namespace

OrientedPoints SamplePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const std::vector<std::vector<int>>& neighbors,
                            const PointSamplerOptions& options) {
  ThrowIfInvalid(options.Check());
  std::vector<std::vector<PointSample>> samples(views.size());
  const std::vector<std::uint8_t> all(views.size(), 1);
  return SampleSome(photos, views, neighbors, options, all, &samples);
}

OrientedPoints UpdatePoints(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                            const std::vector<std::vector<int>>& neighbors,
                            const PointSamplerOptions& options, StereoMemory* memory) {
  ThrowIfInvalid(options.Check());
  const std::uint64_t key = SamplerKey(options);
  std::vector<std::vector<PointSample>> samples(views.size());
  std::vector<std::uint8_t> sampled(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    SettledPhoto& settled = memory->photo.at(photos.photos[i].name);
    sampled[i] = settled.sampler_key != key;
    samples[i].swap(settled.samples);
    settled.sampler_key = 0;  // until the samples are back
  }
  OrientedPoints points = SampleSome(photos, views, neighbors, options, sampled, &samples);
  for (std::size_t i = 0; i < views.size(); ++i) {
    SettledPhoto& settled = memory->photo.at(photos.photos[i].name);
    settled.samples.swap(samples[i]);
    settled.sampler_key = key;
  }
  return points;
}

}  // namespace colmap_ext
