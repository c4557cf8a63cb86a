// The surface of the fused cloud: screened Poisson reconstruction (Kazhdan and Hoppe 2013, by
// Open3D) with the signal that the paper's coverage evaluation starts from.
#pragma once

#include <string>

#include "colmap_ext/scene/oriented_points.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/world_frame.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct SurfaceOptions {
  // Octree depth, 4 … 11; the finest cell is then 1.1 extent / 2^depth. 0: from resolution_m.
  int depth = 0;
  // Edge of the finest cell, metres, >= 0. Finer detail is not reconstructed; time grows with
  // 1 / resolution². 0: two wanted pixels (below), as far as max_vertices allows.
  double resolution_m = 0;
  // The wanted resolution on the surface, mm a pixel, >= 0: a photo cannot tell finer detail than
  // two of its pixels, so the cells need not be finer either. 0: not known, max_vertices decides.
  double ground_sampling_distance_mm = 0;
  // Vertices that an automatic resolution aims at, at most; [1000, 10^7]. 60 000 take 3 s on one
  // core.
  int max_vertices = 60000;
  // Faces whose supporting points are further apart than this are cut off, metres, >= 0. Generous
  // by design: holes in the support must stay closed by surface, or nobody would plan views there;
  // only what Poisson adds far from every point goes. 0: 5 % of the region's diagonal.
  double trim_spacing_m = 0;
  // Smaller connected pieces are dropped, m², >= 0. 0: 0.2 % of the surface.
  double min_component_area_m2 = 0;
  // The surface is cut at the region of interest widened on each side by this part of its diagonal,
  // 0 … 1: surroundings that hide the object or stand beside it are needed.
  double crop_margin_ratio = 0.05;
  // Points of less confidence Γ are left out, 0 … 1.
  double min_confidence = 0.02;

  std::string Check() const;
};

// Section "SurfaceReconstructor".
void BindOptions(OptionSet& set, SurfaceOptions* options);

// `points`: world, with normals (need not be unit). The result has one colour, sample_spacing_m and
// scatter_m a vertex, and faces counter-clockwise seen from where the normals point.
//
// The signal is computed from the points themselves, not from the octree, so that thinning does not
// change it: around each vertex, from the nearest points whose normals agree with it,
//
//   sample_spacing_m = 1 / sqrt(density),  density = (W − max_photo W_photo) / (π r²)
//
// with W the summed confidence of the points within r and W_photo that of one photo: the support
// that remains when the photo that gives most is taken away. A surface that only one photo saw has
// therefore no signal, however dense its points are. Points of unknown photo (-1) count fully.
// For points on a square grid of spacing s and confidence 1 it is s. Never more than the diagonal
// of the cropped region, which stands for "no support".
//
//   scatter_m = sqrt(Σ w (offset² + s²) / Σ w)
//
// over the same points: offset their distance from the vertex along its normal, s² the scatter of
// the points that thinning merged into one. Where no point agrees with the vertex it is that
// diagonal, too.
//
// Same points, same surface, whatever the number of threads (Open3D is run with one: with more, its
// results differ from run to run). Throws UsageError for wrong options, Error for points that are
// not finite, for too few points in the region, and when nothing is left after trimming.
Surface ReconstructSurface(const OrientedPoints& points, const RegionOfInterest& region,
                           const SurfaceOptions& options, const JobControl& job);

}  // namespace colmap_ext
