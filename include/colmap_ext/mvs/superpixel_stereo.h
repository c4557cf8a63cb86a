// Linear dense MVS, from photos and SfM points to one mesh a view (paper, Sec. "Linear Dense MVS").
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "colmap_ext/mvs/photo_exchange.h"
#include "colmap_ext/mvs/stereo_memory.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {

struct SuperpixelStereoResult {
  std::vector<ViewMesh> views;              // one a photo, in the order of the photos
  std::vector<std::vector<int>> neighbors;  // of each view, best first
  StageCost superpixels;
  StageCost stereo;
  StageCost photometric;
  StageCost fusion;
};

// Superpixels, initial solve, confidence and fusion of all photos (with pixels). Photos are worked
// on in parallel; the result does not depend on the number of threads. A photo without SfM points
// or neighbours gets a mesh with supported == 0 or confidence 0. Throws UsageError for options out
// of range, Error for a photo without pixels or of another size than its camera, CancelledError.
SuperpixelStereoResult RunSuperpixelStereo(const PhotoSet& photos,
                                           const SuperpixelOptions& superpixel_options,
                                           const SuperpixelStereoOptions& options,
                                           const JobControl& job);

// The same result to the last bit by several processes, each of which works on its photos; all get
// the whole result. Every process needs all photos with their pixels. `exchange` was made of the
// same photos and options. Throws also when another process does not come along.
SuperpixelStereoResult ShareSuperpixelStereo(const PhotoSet& photos,
                                             const SuperpixelOptions& superpixel_options,
                                             const SuperpixelStereoOptions& options,
                                             const JobControl& job, PhotoExchange* exchange);

// What an update works on.
struct StereoUpdate {
  std::vector<std::vector<int>> neighbors;           // of each photo, best first
  std::vector<std::optional<double>> settled_scale;  // of each photo: SettledScale, if it is kept
  std::vector<std::uint8_t> needs_pixels;  // photos that are solved, and their neighbours: not 0
};

// Photos that keep the mesh of an earlier update: those that were solved with these options, whose
// pose and neighbours still stand to each other as they did (options.keep_tolerance_px), with no
// new photo (one that `memory` does not have) among the neighbours, and with not many more SfM
// points (options.keep_new_points). Pixels are not asked for. With keep_tolerance_px == 0 no photo
// is kept. Throws UsageError for options out of range.
StereoUpdate PlanStereoUpdate(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                              const SuperpixelStereoOptions& options, const StereoMemory& memory);

// Solves the photos that `update` (the plan for the same photos, options and memory) does not keep;
// the meshes of the others, as they are, are their neighbours. So what an update costs depends on
// how many photos are new, not on how many are there; all that is kept lies within the tolerances
// of PlanStereoUpdate of what RunSuperpixelStereo would start from. `memory` then has the result;
// empty at first, which gives what RunSuperpixelStereo gives; after an exception it may be used
// further. Photos need pixels where update.needs_pixels says so. Else as RunSuperpixelStereo.
SuperpixelStereoResult UpdateSuperpixelStereo(const PhotoSet& photos,
                                              const SuperpixelOptions& superpixel_options,
                                              const SuperpixelStereoOptions& options,
                                              const StereoUpdate& update, const JobControl& job,
                                              StereoMemory* memory);

}  // namespace colmap_ext
