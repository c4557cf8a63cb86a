// How many photos, metres and seconds a strategy needs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "true_site.h"

namespace colmap_ext {

// After each photo of a loop, in the order of flight: what was covered, and what it took so far.
struct LoopStep {
  int photos = 0;  // planned ones; the first flight's are not counted
  std::size_t covered = 0;
  double length_m = 0;
  double duration_s = 0;
};

struct LoopResult {
  int first_photos = 0;
  std::vector<LoopStep> steps;  // the first one: before any planned photo
  int iterations = 0;
  double planning_s = 0;    // wall time of the view planning, all iterations
  int dropped = 0;          // planned views that the path stage could not reach
  int planned = 0;          // photos that were planned and flown
  int registered = 0;       // of them; in the loop of photos
  std::string stop_reason;  // of the last plan; empty: the limit of photos
};

// On the model: planning sees the true mesh; photos are where the vehicle happens to be, and all
// are taken to be registered. `ask_reach`: views are only chosen where a way leads. Ends at
// `wanted_covered` points, or at `max_photos` planned ones.
LoopResult RunGeometryLoop(const TrueSite& site, const std::string& strategy,
                           std::size_t wanted_covered, int max_photos, bool ask_reach,
                           const JobControl& job);

// The real one: active_capture in `workspace`, everything by rendered photos. Coverage is that of
// the true mesh by the true poses of the registered photos.
LoopResult RunPhotoLoop(const TrueSite& site, const std::string& strategy, int max_photos,
                        const std::vector<std::string>& arguments,
                        const std::filesystem::path& workspace, const JobControl& job);

}  // namespace colmap_ext
