// Keeps a model where it was.
#pragma once

#include <optional>
#include <vector>

#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// The similarity that brings the photos of `moved` back to where `reference` has them, in the least
// squares sense over the photos that both have (by image id). Uses centres and orientations, so
// that photos on one line are enough. Exact when the old photos moved rigidly. Throws Error when
// fewer than 2 photos are common or their centres coincide.
Sim3d ReferenceFromMoved(const Reconstruction& reference, const Reconstruction& moved);

// A photo before and after a move.
struct PosePair {
  Rigid3d cam_from_reference, cam_from_moved;
};
// The same for poses; nullopt instead of an error.
std::optional<Sim3d> ReferenceFromMoved(const std::vector<PosePair>& poses);

}  // namespace colmap_ext
