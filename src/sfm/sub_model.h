// A part of a model taken out, continued by itself, and brought back.
#pragma once

#include <set>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/scene/reconstruction.h"

namespace colmap_ext {

// The photos that an update works on.
struct UpdateScope {
  std::set<ImageId> missing;     // to be registered
  std::set<ImageId> registered;  // of the model: those that the missing ones match, and a margin
};

// The missing photos are `untried` and those that are joined to them by verified pairs of at least
// kMinInliers; the margin are photos that share most points with those matched. A photo without
// such a pair inside the scope is left out: COLMAP's mapper would not know it.
UpdateScope ChooseScope(const Reconstruction& model,
                        const std::map<ImagePair, TwoViewSummary>& pairs,
                        const std::set<ImageId>& untried);

// These photos with all their keypoints, and the points that at least two of them see. All ids are
// kept. Each image must be in the model.
Reconstruction SubModel(const Reconstruction& model, const std::set<ImageId>& images);

struct MergedPart {
  std::set<ImageId> new_images;
  std::set<Point3DId> changed_points;  // new ones, and those whose photos changed
};

// Brings `after`, which was made from `before` = SubModel(*model, …) with its poses kept, back into
// the model. New photos and points are added; points that were extended or merged stay with what
// the rest of the model sees of them; observations that were dropped are dropped. Points whose
// photos did not change keep their place to the last bit. Positions of changed points come from
// `after` and await an adjustment; their errors, too.
MergedPart MergeSubModel(const Reconstruction& before, const Reconstruction& after,
                         Reconstruction* model);

}  // namespace colmap_ext
