#include "session/take_off_height.h"

#include <utility>
#include <vector>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {

std::optional<double> TakeOffBelowOrigin(const PhotoSet& photos,
                                         const std::filesystem::path& image_path) {
  std::vector<double> below_m;
  for (const PosedPhoto& photo : photos.photos) {
    const auto height_m = ReadPhotoMetadata(image_path / photo.name).relative_height_m;
    if (height_m) below_m.push_back(*height_m - CameraCenter(photo.cam_from_world).z());
  }
  if (below_m.empty()) return std::nullopt;
  return MiddleValue(std::move(below_m));
}

}  // namespace colmap_ext
