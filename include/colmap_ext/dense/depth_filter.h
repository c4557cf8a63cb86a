// What other photos say about a depth map; planes that smooth it and give its normals.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/dense/options.h"
#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

struct DepthView {
  PinholeCamera camera;
  Rigid3d cam_from_world;
  cv::Mat inverse_depth;  // CV_32FC1, camera.width x camera.height: 1/z; 0: none
};

// Where a pixel's point lies in another view.
struct DepthWitness {
  enum class Verdict {
    kNothing,  // outside, behind, no depth there, or hidden by something nearer
    kConfirms,
    kContradicts  // the other view sees something well behind the point, through it
  };
  Verdict verdict = Verdict::kNothing;
  Eigen::Vector3d point_in_world;  // kConfirms: what the other view has there
  double depth = 0;                // kConfirms: along the other's axis
};

// `point_in_world` is seen by `view` at `pixel`. The other's map confirms it when its relative
// depth difference is at most max_depth_error and its own point comes back to `view` within
// max_reprojection_px of `pixel`; it contradicts when its depth there is greater by more than three
// times max_depth_error.
DepthWitness AskWitness(const DepthView& view, const Eigen::Vector2d& pixel,
                        const Eigen::Vector3d& point_in_world, const DepthView& other,
                        const DenseStereoOptions& options);

struct ConfirmedDepth {
  cv::Mat inverse_depth;  // CV_32FC1; 0: none
  cv::Mat photos;         // CV_8UC1: photos that agree, itself counted; 0 where there is none
};

// Keeps a depth that at least min_photos photos agree on, and that not more contradict than
// confirm.
ConfirmedDepth ConfirmDepth(const DepthView& view, const std::vector<DepthView>& others,
                            const DenseStereoOptions& options);

struct PlaneMaps {
  cv::Mat inverse_depth;  // CV_32FC1: of the plane at its pixel; 0: none
  cv::Mat normal;         // CV_32FC3: unit, camera frame, facing the camera; 0: none
};

// Least-squares plane (inverse depth is affine in the pixel on a plane) through the neighbours of
// each pixel that are within max_depth_error of it, refitted to those within 2.5 times the mean
// residual. Pixels with fewer than 6 such neighbours, or on one line, or seen at more than 87
// degrees, become holes: crumbs.
PlaneMaps FitPlanes(const PinholeCamera& camera, const cv::Mat& inverse_depth,
                    const DenseStereoOptions& options);

}  // namespace colmap_ext
