// What an update keeps of earlier ones.
#include <Eigen/Geometry>
#include <cmath>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/stereo_memory.h"
#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "colmap_ext/util/statistics.h"
#include "mvs/memory_keys.h"

namespace colmap_ext {
namespace {

using PhotosByName = std::map<std::string, const PosedPhoto*>;

// Median over the supported facets, of their corners' mean; 0 without any.
double MedianDepth(const ViewMesh& view) {
  std::vector<double> inverse_depths;
  for (std::size_t t = 0; t < view.inverse_depth.size(); ++t) {
    if (view.supported[t] != 0) inverse_depths.push_back(view.inverse_depth[t].mean());
  }
  return inverse_depths.empty() ? 0 : 1.0 / MiddleValue(std::move(inverse_depths));
}

// Now by then; nothing when a neighbour is gone.
std::optional<double> ScaleOfWorld(const SettledPhoto& settled, const PosedPhoto& photo,
                                   const PhotosByName& now) {
  const Eigen::Vector3d center_then = CameraCenter(settled.view.cam_from_world);
  const Eigen::Vector3d center_now = CameraCenter(photo.cam_from_world);
  double sum_then = 0, sum_now = 0;
  for (const SettledPhoto::Neighbor& neighbor : settled.neighbors) {
    const auto other = now.find(neighbor.name);
    if (other == now.end()) return std::nullopt;
    sum_then += (CameraCenter(neighbor.cam_from_world) - center_then).norm();
    sum_now += (CameraCenter(other->second->cam_from_world) - center_now).norm();
  }
  if (settled.neighbors.empty()) return 1.0;
  if (!(sum_then > 0 && sum_now > 0)) return std::nullopt;
  return sum_now / sum_then;
}

// A camera, and a neighbour's that its points are seen in.
struct CameraPairing {
  const PinholeCamera& camera;
  const PinholeCamera& other;
  Rigid3d other_from_camera;

  // Where the neighbour sees what is at `depth` behind a pixel; nothing when behind it.
  std::optional<Eigen::Vector2d> Seen(const Eigen::Vector2d& pixel, double depth) const {
    const Eigen::Vector3d in_other = other_from_camera * (camera.Ray(pixel) * depth);
    if (!(in_other.z() > 0)) return std::nullopt;
    return other.Project(in_other);
  }
};

constexpr double kGrid[] = {1.0 / 6, 0.5, 5.0 / 6};  // of the photo's width and height

// Whether what lies at `depth` then and `scale * depth` now is seen at the same place.
bool HoldsStill(const CameraPairing& then, const CameraPairing& now, double depth, double scale,
                double tolerance_px) {
  for (const double u : kGrid) {
    for (const double v : kGrid) {
      const Eigen::Vector2d pixel(u * then.camera.width, v * then.camera.height);
      const auto seen_then = then.Seen(pixel, depth);
      if (!seen_then || !then.other.Contains(*seen_then)) continue;  // says nothing of the mesh
      const auto seen_now = now.Seen(pixel, scale * depth);
      if (!seen_now || !((*seen_now - *seen_then).norm() <= tolerance_px)) return false;
    }
  }
  return true;
}

// Whether the photo shows the same at the same pixels: undistorting moves them as the lens is
// adjusted.
bool ShowsTheSame(const SettledPhoto& settled, const PosedPhoto& photo, double tolerance_px) {
  if (settled.lens.width <= 0 || photo.lens.width <= 0) return true;  // was never distorted
  const auto in_file = [](const Camera& lens, const PinholeCamera& camera, double u, double v) {
    const Eigen::Vector2d pixel(u * camera.width, v * camera.height);
    const Eigen::Vector2d distorted = ImageFromNormalized(lens, camera.Ray(pixel).hnormalized());
    return Eigen::Vector2d(distorted * camera.width / lens.width);
  };
  for (const double u : kGrid) {
    for (const double v : kGrid) {
      const Eigen::Vector2d then = in_file(settled.lens, settled.view.camera, u, v);
      const Eigen::Vector2d now = in_file(photo.lens, photo.camera, u, v);
      if (!((now - then).norm() <= tolerance_px)) return false;
    }
  }
  return true;
}

bool SameSize(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height;
}

}  // namespace

std::optional<double> SettledScale(const SettledPhoto& settled, const PosedPhoto& photo,
                                   const PhotosByName& now, double tolerance_px) {
  const ViewMesh& view = settled.view;
  if (!SameSize(view.camera, photo.camera)) return std::nullopt;
  if (!ShowsTheSame(settled, photo, tolerance_px)) return std::nullopt;
  const std::optional<double> scale = ScaleOfWorld(settled, photo, now);
  if (!scale) return std::nullopt;
  const double depth = MedianDepth(view);
  if (!(depth > 0)) return std::nullopt;  // nothing was solved
  for (const SettledPhoto::Neighbor& neighbor : settled.neighbors) {
    const PosedPhoto& other = *now.at(neighbor.name);
    if (!SameSize(neighbor.camera, other.camera)) return std::nullopt;
    const CameraPairing pair_then{view.camera, neighbor.camera,
                                  neighbor.cam_from_world * Inverse(view.cam_from_world)};
    const CameraPairing pair_now{photo.camera, other.camera,
                                 other.cam_from_world * Inverse(photo.cam_from_world)};
    if (!HoldsStill(pair_then, pair_now, depth, *scale, tolerance_px)) return std::nullopt;
  }
  return scale;
}

StereoUpdate PlanStereoUpdate(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                              const SuperpixelStereoOptions& options, const StereoMemory& memory) {
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(options.Check());
  const std::size_t count = photos.photos.size();
  StereoUpdate update{FindNeighbors(photos, options), {}, std::vector<std::uint8_t>(count)};
  update.settled_scale.resize(count);
  PhotosByName now;
  for (const PosedPhoto& photo : photos.photos) now[photo.name] = &photo;
  const std::vector<std::vector<int>> points = PointsOfPhotos(photos);
  const std::uint64_t key = StereoKey(superpixel_options, options);
  ParallelFor(count, [&](std::size_t i) {
    const auto settled = memory.photo.find(photos.photos[i].name);
    if (settled == memory.photo.end() || settled->second.stereo_key != key) return;
    if (!(options.keep_tolerance_px > 0)) return;
    const double most_points =
        (1 + options.keep_new_points) * static_cast<double>(settled->second.num_points);
    if (static_cast<double>(points[i].size()) > most_points) return;
    for (const int j : update.neighbors[i]) {
      if (!memory.photo.contains(photos.photos[static_cast<std::size_t>(j)].name)) return;
    }
    update.settled_scale[i] =
        SettledScale(settled->second, photos.photos[i], now, options.keep_tolerance_px);
  });
  for (std::size_t i = 0; i < count; ++i) {
    if (update.settled_scale[i]) continue;
    update.needs_pixels[i] = 1;
    for (const int j : update.neighbors[i]) update.needs_pixels[static_cast<std::size_t>(j)] = 1;
  }
  return update;
}

}  // namespace colmap_ext
