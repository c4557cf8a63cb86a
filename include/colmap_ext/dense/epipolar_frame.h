// Rectification of a pair of photos: in an epipolar image, what one row shows in one photo, the
// same row shows in the other.
#pragma once

#include <Eigen/Core>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// The rectified frame has its origin in the reference camera, its x axis along the baseline: the
// partner's centre is at (baseline, 0, 0). For a point (X, Y, Z) in it, with ρ = sqrt(Y² + Z²), the
// slope X/ρ is all that differs between the photos: slope_reference − slope_partner = baseline/ρ.
//
// Epipolar images have a row for each epipolar plane and a column for each slope:
//   planar:    col = f x/z, row = f y/z (both cameras turned to look across the baseline), or
//   spherical: col = f atan(slope), row = f atan2(y, z), when a camera looks so much along the
//              baseline that a plane would not hold its photo (forward flight).
// Columns and rows count from the direction (0, 0, 1), in pixels, and may be negative.
class EpipolarFrame {
 public:
  // Throws Error when both cameras are at the same place.
  EpipolarFrame(const PinholeCamera& reference, const Rigid3d& reference_from_world,
                const Rigid3d& partner_from_world);

  bool is_planar() const { return is_planar_; }
  double baseline() const { return baseline_; }
  double focal_px() const { return focal_px_; }

  // Direction (any length) in the rectified frame.
  Eigen::Vector3d FromReference(const Eigen::Vector3d& in_reference) const {
    return rect_from_reference_ * in_reference;
  }
  Eigen::Vector3d ToReference(const Eigen::Vector3d& in_rect) const {
    return rect_from_reference_.transpose() * in_rect;
  }
  Eigen::Vector3d ToPartner(const Eigen::Vector3d& in_rect) const {
    return partner_from_rect_ * in_rect;
  }

  // (column, row) of a direction in the rectified frame (planar: z > 0).
  Eigen::Vector2d Position(const Eigen::Vector3d& direction) const;
  Eigen::Vector3d Direction(double col, double row) const;
  double Slope(double col, double row) const;
  double Column(double slope, double row) const;

  // Columns and rows that hold the whole reference photo.
  Eigen::Vector2d min_position() const { return min_position_; }
  Eigen::Vector2d max_position() const { return max_position_; }

 private:
  bool TryBounds(const PinholeCamera& reference);
  void ExtendToPoles(const PinholeCamera& reference);

  double baseline_ = 0;
  double focal_px_ = 0;
  bool is_planar_ = true;
  Eigen::Matrix3d rect_from_reference_;
  Eigen::Matrix3d partner_from_rect_;
  Eigen::Vector2d min_position_;
  Eigen::Vector2d max_position_;
};

}  // namespace colmap_ext
