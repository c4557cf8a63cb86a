#include "colmap_ext/scene/photo_scale.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {

void DownscalePhotos(int max_width_px, PhotoSet* photo_set) {
  ParallelFor(photo_set->photos.size(), [&](std::size_t i) {
    PosedPhoto& photo = photo_set->photos[i];
    const int width = photo.camera.width;
    if (width <= max_width_px) return;
    const double ratio = static_cast<double>(max_width_px) / width;
    const int height = std::max(
        1, static_cast<int>(std::lround(ratio * static_cast<double>(photo.camera.height))));
    photo.camera = ScaleTo(photo.camera, max_width_px, height);
    if (photo.bgr.empty()) return;
    cv::Mat scaled;
    cv::resize(photo.bgr, scaled, cv::Size(max_width_px, height), 0, 0, cv::INTER_AREA);
    photo.bgr = scaled;
  });
}

}  // namespace colmap_ext
