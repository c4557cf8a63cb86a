// Linear dense MVS, from photos and SfM points to one mesh a view (paper, Sec. "Linear Dense MVS").
#pragma once

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

// How many photos' steps were taken from memory.
struct StereoReuse {
  int partitions = 0;
  int solves = 0;
  int passes = 0;  // over all passes of fusion
};

struct SuperpixelStereoResult {
  std::vector<ViewMesh> views;              // one a photo, in the order of the photos
  std::vector<std::vector<int>> neighbors;  // of each view, best first
  StageCost superpixels;
  StageCost stereo;
  StageCost photometric;
  StageCost fusion;
  StereoReuse reused;
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

// The same result to the last bit, sooner: what `memory` holds of earlier runs is used wherever it
// was computed from the same input. So new photos solve themselves, and of the others only those
// change that new points, a moved pose or a changed neighbour reach. `memory` is updated; empty at
// first; after an exception it may be used further.
SuperpixelStereoResult UpdateSuperpixelStereo(const PhotoSet& photos,
                                              const SuperpixelOptions& superpixel_options,
                                              const SuperpixelStereoOptions& options,
                                              const JobControl& job, StereoMemory* memory);

}  // namespace colmap_ext
