// Hashes of what superpixel stereo is computed from.
#pragma once

#include <cstdint>
#include <vector>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

std::uint64_t PartitionKey(const PosedPhoto& photo, const SuperpixelOptions& options);

std::uint64_t SolveKey(std::uint64_t partition_key, const PhotoSet& photos, std::size_t photo,
                       const std::vector<int>& points_of_photo,
                       const SuperpixelStereoOptions& options);

// Of the options that a mesh depends on, and of those that its samples do beside it. Never 0.
std::uint64_t StereoKey(const SuperpixelOptions& superpixel_options,
                        const SuperpixelStereoOptions& options);
std::uint64_t SamplerKey(const PointSamplerOptions& options);

}  // namespace colmap_ext
