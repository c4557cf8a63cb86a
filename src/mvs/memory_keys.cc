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

void AddRow(const DepthRow& row, ContentHash* hash) {
  hash->Add(row.triangle).Add(row.barycentric).Add(row.inverse_depth).Add(row.weight);
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

std::uint64_t ViewKey(std::uint64_t solve_key, const ViewMesh& view) {
  ContentHash hash;
  hash.Add(solve_key).Add(view.inverse_depth).Add(view.supported).Add(view.confidence);
  return hash.value();
}

std::uint64_t PassKey(const std::vector<std::uint64_t>& view_keys, std::size_t view,
                      const std::vector<int>& neighbors, const std::vector<DepthRow>& extra_rows) {
  ContentHash hash;
  hash.Add(view_keys[view]);
  for (const int j : neighbors) hash.Add(view_keys[static_cast<std::size_t>(j)]);
  for (const DepthRow& row : extra_rows) AddRow(row, &hash);
  return hash.value();
}

}  // namespace colmap_ext
