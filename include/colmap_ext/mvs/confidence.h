// Confidence of facets (paper, Sec. "Linear Dense MVS", "Confidence Evaluation").
#pragma once

#include <vector>

#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// The cues of one triangle.
struct ConfidenceCues {
  int witnesses = 0;       // neighbours that see the facet; 0: Γ = 0
  double position_px = 0;  // mean ē_p: forward-backward reprojection of the centroid
  double normal_rad = 0;   // mean ē_n: angle to the normal of the corresponding facet
  double view_rad = 0;     // e_v: angle between the normal and the direction to the camera
};

// Eq. "confidence_score": Γ = exp(-ē_p/σ_p) exp(-ē_n/σ_n) (1 - exp(-cos²(e_v)/σ_v)), 0 without
// witness.
double ConfidenceScore(const ConfidenceCues& cues, const SuperpixelStereoOptions& options);

// The cues of each triangle of `view` against its neighbours. A neighbour is a witness of a facet
// when the facet's centroid projects into it on a supported triangle that is not nearer than the
// facet by more than options.occlusion_tolerance (else the facet is hidden there). Unsupported
// triangles have no witness. `lookups` belong to `views`, one each.
std::vector<ConfidenceCues> EvaluateCues(const std::vector<ViewMesh>& views,
                                         const std::vector<ViewLookup>& lookups,
                                         const std::vector<int>& neighbors_of_view, int view,
                                         const SuperpixelStereoOptions& options);

// The factors of Γ pixel by pixel, each in [0, 1]: channel 0 position, 1 normal, 2 view, 3 their
// product. 0 where a pixel has no triangle or its triangle has no witness.
DenseMap ConfidenceCueMaps(const std::vector<ConfidenceCues>& cues, const cv::Mat1i& triangle_at,
                           const SuperpixelStereoOptions& options);

// Sets the confidence of some views (`which`: their indices), in parallel; reads nothing but
// depths.
void EvaluateConfidence(const std::vector<ViewLookup>& lookups,
                        const std::vector<std::vector<int>>& neighbors,
                        const std::vector<std::size_t>& which,
                        const SuperpixelStereoOptions& options, std::vector<ViewMesh>* views);

}  // namespace colmap_ext
