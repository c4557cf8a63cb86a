// Multi-view fusion (paper, Sec. "Linear Dense MVS", "Multi-view Depth Fusion").
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Rows of E_fusion (Eq. "fusion_term") for the facets of `view` whose confidence is at most
// options.fixed_confidence. The confident facets of the neighbours that face the view are projected
// into it; on a pixel grid each gives its depth to the facet that it covers, weighted by its
// confidence and by colour and normal proximity. Of these a facet follows the depths that agree
// best (options.fusion_space_tolerance); a nearer group wins over a farther one that is not clearly
// stronger, for it hides it.
std::vector<DepthRow> CollectFusionRows(const std::vector<ViewMesh>& views,
                                        const std::vector<ViewLookup>& lookups,
                                        const std::vector<int>& neighbors_of_view, int view,
                                        const SuperpixelStereoOptions& options);

// The part of a view that a pass changes.
struct FacetDepths {
  std::vector<Eigen::Vector3d> inverse_depth;  // as in ViewMesh
  std::vector<std::uint8_t> supported;         // as in ViewMesh
};

// One view of a pass: solved again from the result of the pass before (so the order of views does
// not matter), with E_fusion's rows and `extra_rows` (what else is known of its facets: photometric
// hypotheses; rows of fixed facets do nothing), facets with confidence above
// options.fixed_confidence fixed.
FacetDepths FuseView(const LinearStereo& solver, const std::vector<ViewMesh>& views,
                     const std::vector<ViewLookup>& lookups,
                     const std::vector<int>& neighbors_of_view,
                     const std::vector<DepthRow>& extra_rows, int view,
                     const SuperpixelStereoOptions& options);

// Share of a view's facets with a corner whose inverse depth changed by more than `tolerance` of
// it.
double MovedShare(const std::vector<Eigen::Vector3d>& before,
                  const std::vector<Eigen::Vector3d>& after, double tolerance);

}  // namespace colmap_ext
