// Where photos were taken and look, from the model where it has them, else from what they say.
#pragma once

#include <vector>

#include "colmap_ext/sfm/sparse_update.h"
#include "photo_catalog.h"

namespace colmap_ext {

// Where the photos of the catalog are, in its order: from the model of `input` where it has them
// and is in the frame of the catalog, else from what was measured.
std::vector<PhotoPlace> PlacesOf(const SparseUpdateInput& input, const PhotoCatalog& catalog);

// Registered photos with a measured position, in name order.
std::vector<MeasuredCamera> MeasuredCamerasOf(const Reconstruction& model,
                                              const PhotoCatalog& catalog);

// Unit vectors along which the photos look, in the model.
std::vector<Eigen::Vector3d> OpticalAxes(const Reconstruction& model);
// All within 15 degrees of their mean: the focal length cannot be told from the distance.
bool AllLookOneWay(const std::vector<Eigen::Vector3d>& axes);
bool AllFocalsKnown(const PhotoCatalog& catalog);

// Whether the first model should estimate the intrinsics (SparseUpdateOptions::refine_intrinsics).
bool RefineIntrinsics(const SparseUpdateOptions& options, const SparseUpdateInput& input,
                      const PhotoCatalog& catalog);

}  // namespace colmap_ext
