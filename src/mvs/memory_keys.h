// Hashes of what each step of superpixel stereo is computed from (StereoMemory).
#pragma once

#include <cstdint>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

std::uint64_t PartitionKey(const PosedPhoto& photo, const SuperpixelOptions& options);

std::uint64_t SolveKey(std::uint64_t partition_key, const PhotoSet& photos, std::size_t photo,
                       const std::vector<int>& points_of_photo,
                       const SuperpixelStereoOptions& options);

// A view as it is, by the key of its solve and its depths, support and confidence.
std::uint64_t ViewKey(std::uint64_t solve_key, const ViewMesh& view);

// The next pass of fusion: the view, its neighbours in order, and its rows beside fusion's.
std::uint64_t PassKey(const std::vector<std::uint64_t>& view_keys, std::size_t view,
                      const std::vector<int>& neighbors, const std::vector<DepthRow>& extra_rows);

}  // namespace colmap_ext
