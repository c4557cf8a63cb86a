// The pictures of an iteration.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

struct IterationScenery {
  const PhotoSet& photos;              // with pixels
  const std::vector<ViewMesh>& views;  // one a photo
  const Surface& surface;
  const CoverageMap& coverage;
  const std::vector<PlannedView>& planned;
  const FlightPath& path;
};

// Writes superpixels.png (the newest photo with its superpixel mesh), confidence.png, surface.png,
// coverage.png and path.png into `folder`, and
// overlays.json (view_overlay.h) beside it.
void WriteIterationPictures(const IterationScenery& scenery, const std::filesystem::path& folder);

}  // namespace colmap_ext
