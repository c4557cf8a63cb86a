#include "scene/undistort.h"

#include <opencv2/imgproc.hpp>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {

cv::Mat BuildUndistortMap(const Camera& camera, const PinholeCamera& pinhole) {
  cv::Mat map(pinhole.height, pinhole.width, CV_32FC2);
  ParallelFor(pinhole.height, [&](int row) {
    for (int col = 0; col < pinhole.width; ++col) {
      // COLMAP's pixel centres are at + 0.5, OpenCV's at whole numbers.
      const Eigen::Vector3d ray = pinhole.Ray({col + 0.5, row + 0.5});
      const Eigen::Vector2d pixel = ImageFromNormalized(camera, ray.head<2>());
      map.at<cv::Vec2f>(row, col) = {static_cast<float>(pixel.x() - 0.5),
                                     static_cast<float>(pixel.y() - 0.5)};
    }
  });
  return map;
}

cv::Mat Undistort(const cv::Mat& photo, const cv::Mat& map) {
  cv::Mat undistorted;
  cv::remap(photo, undistorted, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return undistorted;
}

}  // namespace colmap_ext
