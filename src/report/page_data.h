// One iteration of a session as JSON for the page. Formats: docs/file_formats.md.
#pragma once

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/workspace.h"

namespace colmap_ext {

// What the page draws: photos, sparse points, surface, coverage map, views, path; what an iteration
// does not have is left out. Throws Error for a file that is malformed.
Json IterationForPage(const IterationFiles& files);

// The fused cloud, evenly thinned to at most `max_points`; null when there is none.
Json FusedCloudForPage(const IterationFiles& files, int max_points);

}  // namespace colmap_ext
