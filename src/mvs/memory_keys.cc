#include "mvs/memory_keys.h"

#include "colmap_ext/util/options.h"
#include "mvs/content_hash.h"

namespace colmap_ext {
namespace {

// Every option counts, by name and value, as the option files have them.
template <typename Options>
void AddOptions(Options options, ContentHash* hash) {
  OptionSet set;
  BindOptions(set, &options);
  for (const char c : set.ToIni()) hash->Add(c);
}

}  // namespace

std::uint64_t PartitionKey(const PosedPhoto& photo, const SuperpixelOptions& options) {
  ContentHash hash;
  AddOptions(options, &hash);
  return hash.Add(photo.bgr).value();
}

std::uint64_t SolveKey(std::uint64_t partition_key, const PhotoSet& photos, std::size_t photo,
                       const std::vector<int>& points_of_photo,
                       const SuperpixelStereoOptions& options) {
  ContentHash hash;
  AddOptions(options, &hash);
  const PosedPhoto& posed = photos.photos[photo];
  const PinholeCamera& camera = posed.camera;
  hash.Add(partition_key).Add(camera.width).Add(camera.height);
  hash.Add(camera.fx).Add(camera.fy).Add(camera.cx).Add(camera.cy);
  hash.Add(Eigen::Vector4d(posed.cam_from_world.rotation.coeffs()));
  hash.Add(posed.cam_from_world.translation);
  for (const int p : points_of_photo) {
    const SupportPoint& point = photos.points[static_cast<std::size_t>(p)];
    hash.Add(point.position).Add(point.error_px).Add(point.photo_indices.size());
  }
  return hash.value();
}

std::uint64_t StereoKey(const SuperpixelOptions& superpixel_options,
                        const SuperpixelStereoOptions& options) {
  ContentHash hash;
  AddOptions(superpixel_options, &hash);
  AddOptions(options, &hash);
  return hash.value() | 1;
}

std::uint64_t SamplerKey(const PointSamplerOptions& options) {
  ContentHash hash;
  AddOptions(options, &hash);
  return hash.value() | 1;
}

}  // namespace colmap_ext
