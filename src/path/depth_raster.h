#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "path/face_clusters.h"

namespace colmap_ext {

// What a photo's lines of sight meet, pixel by pixel of a small image, on the safe side: a pixel is
// the whole pyramid of its rays, not only the one through its centre. So a pole that is thinner
// than a pixel hides what is behind it, as it does in the photo.
class DepthRaster {
 public:
  DepthRaster(const FaceClusters& surface, const Rigid3d& cam_from_world,
              const PinholeCamera& camera);

  // Whether the whole ball lies before the surface: every pixel that it touches shows only surface
  // behind the ball, and confident surface at its corners (a straight edge beyond which there is
  // none cannot cross a pixel without cutting off a corner). The ball must be in the picture
  // wholly.
  bool HasSeenPast(const Eigen::Vector3d& center, double radius_m) const;

 private:
  struct ScreenPolygon;  // a piece of the surface in the image

  struct PixelBox;
  struct Vertex;

  Eigen::Vector2d HalfAxes(const Eigen::Vector3d& center_in_cam, double radius_m) const;
  bool IsOutside(const Eigen::Vector3d& center_in_cam, double radius_m) const;
  bool IsHidden(const Eigen::Vector3d& center_in_cam, double radius_m,
                const std::vector<float>& at_corner) const;
  void Draw(const std::array<const Vertex*, 3>& face, bool confident,
            std::vector<float>* at_corner);
  bool IsHidden(const PixelBox& pixels, float inverse_depth,
                const std::vector<float>& at_corner) const;
  void SetNearest(const ScreenPolygon& screen, float most, int row, int col);
  void SetCorner(const ScreenPolygon& screen, int row, int col, bool confident,
                 std::vector<float>* at_corner);

  Rigid3d cam_from_world_;
  PinholeCamera camera_;
  // 1/m, of the nearest point of the surface in the pixel's pyramid; 0: none there.
  std::vector<float> largest_inverse_depth_;
  // Of the nearest surface at the pixels' corners, one more a row and column than pixels; 0 also
  // where none is.
  std::vector<char> is_confident_;
};

}  // namespace colmap_ext
