// The built-in dense reconstruction: a depth map a photo, filtered by the others, fused.
#pragma once

#include "colmap_ext/dense/back_end.h"
#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/dense/stereo_partners.h"

namespace colmap_ext {

// How deep each photo of `photos` looks: from its points and from the depth maps of the dense
// workspace `prior_path` (when not empty; photos without a map there keep their points).
std::vector<DepthRange> DepthRanges(const PhotoSet& photos,
                                    const std::filesystem::path& prior_path);

// Memory that matching one photo takes, MiB: an estimate from the sizes of its buffers.
double MatchingMemoryMib(const PinholeCamera& camera, int num_partners);

// Three passes over the photos, each parallel over photos: depth from the partners
// (depth_estimate.h), kept in <workspace>/builtin/; confirmed by the others and smoothed
// (depth_filter.h), kept as COLMAP's depth, normal and confidence maps; fused (depth_fusion.h).
// confidence = 1 − 1/(photos that agree). Each photo's file is written at once, whole: a stopped
// run goes on where it was, and gives the same bytes. Maps that were made from other photos, poses
// or options are thrown away, with a message. Photos without partners get no maps, and are named.
// Several processes (request.rank) each work on their share of every pass and wait for the others'
// files before the next one; the first gets the cloud, to the last bit that of one process, and the
// others an empty one.
//
// Throws Error when no photo has a partner, or nothing was reconstructed; UsageError for options.
OrientedPoints ReconstructBuiltin(const DenseRequest& request, const DenseStereoOptions& options,
                                  const JobControl& job);

}  // namespace colmap_ext
