// Which pairs of photos an update matches.
#pragma once

#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "photo_catalog.h"
#include "update_database.h"

namespace colmap_ext {

// Pairs of photos that are worth matching and not in the database yet: at least one of each was
// never matched with anything. What the given model knows of the surface tells what photos show.
std::vector<ImagePair> ChooseImagePairs(const DatabaseView& database, const PhotoCatalog& catalog,
                                        const SparseUpdateInput& input,
                                        const PairingOptions& options);

}  // namespace colmap_ext
