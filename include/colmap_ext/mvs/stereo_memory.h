// What superpixel stereo keeps of photos, for the time when more of them are there.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/mvs/points.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// A photo's mesh as it was solved, and what tells whether it still holds (SettledScale).
struct SettledPhoto {
  // A neighbour as it stood then.
  struct Neighbor {
    std::string name;
    PinholeCamera camera;
    Rigid3d cam_from_world;
  };

  std::uint64_t stereo_key = 0;     // hash of the options that it was solved with
  std::uint64_t partition_key = 0;  // hash of the pixels and options of view.image
  Camera lens;                      // the photo's, then
  ViewMesh view;                    // with its pose then; photo_index means nothing
  std::vector<Neighbor> neighbors;  // best first
  std::uint64_t num_points = 0;     // SfM points that it observed
  std::uint64_t sampler_key = 0;    // hash of the options of `samples`; 0: none yet
  std::vector<PointSample> samples;
};

struct StereoMemory {
  std::map<std::string, SettledPhoto> photo;  // by name
};

// What the depths of `settled` are to be multiplied with (its inverse depths divided by) for the
// world as it is now; nothing when its mesh no longer holds. An adjustment moves all photos a
// little, and georegistration turns, shifts and scales the world: a mesh, which is in the frame of
// its photo, holds as long as its photo and the neighbours that it was solved with stand to each
// other as they did, and its lens was not adjusted by more than that. So they do when a grid of its
// pixels, at its median depth, appears in every neighbour within `tolerance_px` of where it did,
// but for the scale of the world: the sum of the distances to the neighbours, now by then. Not when
// one of these is gone (`now`: by name).
std::optional<double> SettledScale(const SettledPhoto& settled, const PosedPhoto& photo,
                                   const std::map<std::string, const PosedPhoto*>& now,
                                   double tolerance_px);

}  // namespace colmap_ext
