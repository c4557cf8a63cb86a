// The search for each facet's most photo-consistent plane, in one view.
#pragma once

#include <array>
#include <vector>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/view_mesh.h"
#include "mvs/photo_patch.h"

namespace colmap_ext {

// Correlations with the neighbours; unseen ones are kUnseen.
struct PatchScore {
  static constexpr int kMaxNeighbors = 4;
  std::array<float, kMaxNeighbors> correlation{};
  int witnesses = 0;
  float best = kUnseen;  // mean of the better half of the witnesses, three at most
};

// Of a plane in the first kMaxNeighbors of the neighbours. Gives up when the first two witnesses
// are both below `hopeless`.
PatchScore ScorePlane(const PhotoPatch& patch, const PatchPlane& plane,
                      const std::vector<PixelTransfer>& transfers, float hopeless = kUnseen);

class PlaneSearch {
 public:
  // `transfers`: to the neighbours, best first; those after the fourth are not used. All are
  // referred to.
  PlaneSearch(const ViewMesh& mesh, const ViewLookup& lookup, const cv::Mat1i& grey,
              std::vector<PixelTransfer> transfers, const SuperpixelStereoOptions& options);

  // Planes (in the view's camera) to try for all triangles of a superpixel.
  void AddHypothesis(int superpixel, const Eigen::Vector3d& plane_in_cam);

  // Of the triangles' present planes; no witness where they are not supported.
  void ScorePresentPlanes();
  // Facets that are not explained try the hypotheses of their superpixel and the planes of facets
  // around; forwards, then backwards through the triangles, so that good planes spread.
  void TryHypotheses();
  // Gauss-Newton steps for facets that are explained; then their rows.
  std::vector<DepthRow> RefineAndCollectRows();

 private:
  struct Refined;
  const PhotoPatch& patch(std::size_t t);  // made when it is first asked for
  void TryAround(std::size_t t, bool with_superpixel);
  bool IsNew(std::size_t t, const PatchPlane& plane, const std::vector<PatchPlane>& tried) const;
  Refined Refine(std::size_t t);
  void AppendRows(std::size_t t, const Refined& refined, std::vector<DepthRow>* rows) const;

  const ViewMesh& mesh_;
  const ViewLookup& lookup_;
  const cv::Mat1i& grey_;
  std::vector<PixelTransfer> transfers_;
  SuperpixelStereoOptions options_;
  std::vector<PhotoPatch> patches_;  // of each triangle, once it was asked for
  std::vector<std::uint8_t> has_patch_;
  std::vector<Eigen::Vector3d> planes_;                   // best so far, in the camera
  std::vector<PatchScore> scores_;                        // of these
  std::vector<std::vector<Eigen::Vector3d>> hypotheses_;  // of each superpixel
  double median_inverse_depth_ = 0;
};

}  // namespace colmap_ext
