// Which triangle covers a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"

namespace colmap_ext {

// CV_32SC1: for each pixel the triangle that covers its centre; -1 where there is none.
cv::Mat1i RasterizeTriangleIds(const ImageMesh& mesh, int width, int height);

// Barycentric coordinates of `pixel` in the triangle a, b, c (area not zero); they sum to 1.
Eigen::Vector3d Barycentric(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                            const Eigen::Vector2d& c, const Eigen::Vector2d& pixel);

// Twice the area of a, b, c; positive when they turn from x to y.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Calls visit(x, y) for the integer pixels, with x and y multiples of `step` plus step / 2, whose
// centres lie in the triangle, clipped to the image.
template <typename Visit>
void ForEachPixelInTriangle(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                            const Eigen::Vector2d& c, int width, int height, int step,
                            const Visit& visit);

}  // namespace colmap_ext

#include "mvs/raster_inl.h"
