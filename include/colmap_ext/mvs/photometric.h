// Photo-consistency: past the paper. Facets are compared, as patches under the homographies of
// their planes, with what the neighbouring photos show; where the plane is wrong, hypotheses are
// tried; what the photos say about the plane that fits best becomes rows of the same linear system.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// Photo-consistency of one facet with its present plane.
struct PhotoCue {
  int witnesses = 0;      // neighbours that the whole patch projects into; 0: nothing is known
  float correlation = 0;  // mean of the better half of them (three at most), in (-1, 1)
  float deviation = 0;    // of the patch's grey values: its texture
};

// The factor of Γ that a cue gives, in (0, 1]: exp(-(e - e_0) / σ_c) with e = 1 - correlation over
// what the patch's texture lets one expect. 1 where too little texture makes it say nothing.
double PhotoConsistency(const PhotoCue& cue, const SuperpixelStereoOptions& options);

// The photos' grey values and points. Immutable after construction.
class PhotometricStage {
 public:
  // `photos` and `neighbors` must outlive it. Nothing may be asked of a photo without pixels, or
  // with a neighbour without them.
  PhotometricStage(const PhotoSet& photos, const std::vector<std::vector<int>>& neighbors,
                   const SuperpixelStereoOptions& options);

  // Rows for the facets of `view` that some plane explains. The plane is the present one, or a
  // better one among those of adjacent facets, of neighbours' facets that project into the
  // superpixel, and through SfM points nearby; refined by Gauss-Newton steps on the normalised grey
  // values. Rows are a factor of the normal equations there: three a facet, whose `barycentric` is
  // a direction in the space of its corners' inverse depths (it need not sum to 1) and whose weight
  // says how well the photos determine it; so flat or occluded patches say little, and an edge
  // speaks only across itself. Occlusion: only the better half of the neighbours count.
  std::vector<DepthRow> CollectRows(const std::vector<ViewMesh>& views,
                                    const std::vector<ViewLookup>& lookups, int view) const;

  // The cue of each triangle of `view`; those with keep[t] != 0 stay as they are in `cues` (a cue
  // depends on the triangle's own plane only). `keep` may be empty: none; else `cues` has one entry
  // a triangle.
  void EvaluateCues(const std::vector<ViewMesh>& views, const std::vector<ViewLookup>& lookups,
                    int view, const std::vector<std::uint8_t>& keep,
                    std::vector<PhotoCue>* cues) const;

 private:
  const PhotoSet& photos_;
  const std::vector<std::vector<int>>& neighbors_;
  SuperpixelStereoOptions options_;
  std::vector<cv::Mat1i> grey_;                    // of each photo, as PackGrey makes it
  std::vector<std::vector<int>> points_of_photo_;  // in photos_.points
};

}  // namespace colmap_ext
