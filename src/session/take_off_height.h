// How high the photos were taken above the place of take-off.
#pragma once

#include <filesystem>
#include <optional>

#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

// How far the take-off place lies below the origin of the (metric) world, metres: the median over
// the photos that say how high above it they were taken (PhotoMetadata::relative_height_m) of that
// less the height of their camera in the model. nullopt when none says. Photos are read below
// `image_path`; throws as ReadPhotoMetadata.
std::optional<double> TakeOffBelowOrigin(const PhotoSet& photos,
                                         const std::filesystem::path& image_path);

}  // namespace colmap_ext
