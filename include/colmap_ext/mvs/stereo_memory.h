// What superpixel stereo keeps of photos, for the time when more of them are there.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// Steps of one photo, each with a hash of all that it was computed from. A step is taken from here
// only when that is the same again, byte by byte, so that what is kept never changes a result.
struct PhotoMemory {
  std::uint64_t partition_key = 0;  // of pixels and options
  std::shared_ptr<const ImageMesh> partition;
  std::uint64_t solve_key = 0;  // of partition, camera, pose, SfM points and options
  std::shared_ptr<const LinearStereo> solver;
  cv::Mat1i triangle_at;  // of the partition
  struct Pass {
    std::uint64_t key = 0;  // of the view's and its neighbours' results of the pass before
    FacetDepths depths;
  };
  std::vector<Pass> passes;  // of fusion
  struct PhotometricPass {
    std::uint64_t key = 0;  // of the view's and its neighbours' initial results
    std::vector<DepthRow> rows;
    FacetDepths depths;
  } photometric;
};

struct StereoMemory {
  std::map<std::string, PhotoMemory> photo;  // by name
};

}  // namespace colmap_ext
