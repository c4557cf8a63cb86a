// The pixels around a facet, compared with what its plane maps them to in a neighbour.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// Inverse depth on a patch: affine in the pixel, about the patch's centre c with its radius r:
// d(p) = a · (1, (p.x - c.x) / r, (p.y - c.y) / r).
using PatchPlane = Eigen::Vector3f;

// A fixed number of pixels on a grid over a facet and a margin, and their weights: 1 on the facet's
// own superpixel, less on others the more their colour differs.
struct PhotoPatch {
  static constexpr int kSamples = 32;
  using Samples = Eigen::Array<float, kSamples, 1>;

  Samples x, y;         // pixel positions about the centre
  Samples weight;       // sum 1
  Samples pattern;      // grey minus its mean, times weight
  float variance = 0;   // of the grey values, weighted
  float deviation = 0;  // sqrt(variance + kNoiseVariance)
  Eigen::Vector2f center;
  float radius = 1;

  // Of grey levels: sensor and compression. Patches with less texture than that cannot score high.
  static constexpr float kNoiseVariance = 4.0F;
};

// The grey values that patches are compared in, blurred a little. CV_32SC1, of the photo's size:
// each entry holds four pixels of 8 bits, its own in the lowest, then its right, lower and lower
// right neighbours (at the border the last pixel again): all that bilinear interpolation reads, at
// once.
cv::Mat1i PackGrey(const cv::Mat& bgr);

// `grey`: the view's own.
PhotoPatch MakePatch(const ViewMesh& mesh, const cv::Mat1i& triangle_at, const cv::Mat1i& grey,
                     int triangle, double color_sigma);

// The plane {X: plane_in_cam · X = 1} on a patch, and back.
PatchPlane ToPatchPlane(const Eigen::Vector3d& plane_in_cam, const PinholeCamera& camera,
                        const PhotoPatch& patch);
Eigen::Vector3d FromPatchPlane(const PatchPlane& plane, const PinholeCamera& camera,
                               const PhotoPatch& patch);

// How pixels of a view map into a neighbour: (M (x, y, 1) + b d), divided by its third coordinate.
struct PixelTransfer {
  Eigen::Matrix3f matrix;
  Eigen::Vector3f shift;
  cv::Mat1i grey;  // of the neighbour

  PixelTransfer(const ViewLookup& view, const ViewLookup& neighbor, cv::Mat1i grey_of_neighbor);
};

// Weighted normalised cross-correlation, with kNoiseVariance added to both variances, so it lies in
// (-1, 1); kUnseen when a sample falls outside of the neighbour or behind it.
inline constexpr float kUnseen = -2.0F;
float CompareInNeighbor(const PhotoPatch& patch, const PatchPlane& plane,
                        const PixelTransfer& transfer);

// Adds the normal equations of the difference of normalised patches, for a step of the plane's
// three coefficients: hessian += Σ w JᵀJ / s², gradient += Σ w Jᵀr / s², s² the variance of the
// residual. Returns the correlation as above, and adds nothing when it is below `min_correlation`.
float AddNormalEquations(const PhotoPatch& patch, const PatchPlane& plane,
                         const PixelTransfer& transfer, float min_correlation,
                         Eigen::Matrix3f* hessian, Eigen::Vector3f* gradient);

}  // namespace colmap_ext
