#pragma once

#include "colmap_ext/sfm/sparse_update.h"

namespace colmap_ext {

// Only the first step of UpdateSparseModel, for photos that arrive while others are still to be
// taken: the features of the photos that the database does not have yet. The update that follows
// gives the same model, but for the order of the photos' ids. Throws as UpdateSparseModel does.
void ExtractNewFeatures(const SparseUpdateInput& input, const SparseUpdateOptions& options,
                        const JobControl& job);

}  // namespace colmap_ext
