// The linear solve of one view (paper, Sec. "Linear Dense MVS", "MVS Formulation" and
// "Initialization"): given the triangles of a photo and SfM points, three inverse depths a
// triangle.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// One observation of inverse depth inside a triangle: a row of E_sfm (Eq. "sfm"), or of E_fusion
// (Eq. "fusion_term").
struct DepthRow {
  int triangle = 0;
  // Of the corners' inverse depths. Sums to 1 for a point of the triangle; rows about a plane's
  // slant may sum to anything.
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  double inverse_depth =
      0;  // 1/z in the view's camera frame, in the units of the world, times that
  double weight = 1;
};

// For each photo the indices of the points that it observes, ascending.
std::vector<std::vector<int>> PointsOfPhotos(const PhotoSet& photos);

// Rows of the SfM points that photo `photo_index` observes (its entry of PointsOfPhotos), by their
// projection. Weight: less for a large reprojection error, half for a track of two.
std::vector<DepthRow> CollectSfmRows(const PhotoSet& photos, int photo_index,
                                     const std::vector<int>& points_of_photo, const ImageMesh& mesh,
                                     const cv::Mat1i& triangle_at);

// Solves one view, again and again with different rows. Immutable after construction; copies share
// what they hold.
class LinearStereo {
 public:
  // `mesh` is the partition of the photo, `triangle_at` its TriangleIdMap, `points_of_photo` its
  // entry of PointsOfPhotos.
  LinearStereo(const PhotoSet& photos, int photo_index, const std::vector<int>& points_of_photo,
               const ImageMesh& mesh, const cv::Mat1i& triangle_at,
               const SuperpixelStereoOptions& options);

  // Minimises Eq. "surface_reconstruction_init": E_sfm + λ_s E_smooth + λ_c E_continuity.
  // Triangles that no SfM point's region reaches have supported == 0; in a view without any SfM
  // point all inverse depths are 0. Confidence is 0 everywhere.
  const ViewMesh& initial() const;

  // Minimises Eq. "surface_reconstruction_fusion": the terms above and `rows` (E_fusion and
  // whatever else is known of a facet's depth), over the triangles with fixed[t] == 0; the others
  // keep mesh->inverse_depth. Triangles with rows become supported. Leaves the mesh alone when
  // there is nothing to go by.
  void Refine(const std::vector<std::uint8_t>& fixed, const std::vector<DepthRow>& rows,
              ViewMesh* mesh) const;
  // The same in parts: `inverse_depth` and `supported` of a ViewMesh.
  void Refine(const std::vector<std::uint8_t>& fixed, const std::vector<DepthRow>& rows,
              std::vector<Eigen::Vector3d>* inverse_depth,
              std::vector<std::uint8_t>* supported) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace colmap_ext
