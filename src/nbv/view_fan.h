#pragma once

#include <utility>
#include <vector>

#include "nbv/search_context.h"

namespace colmap_ext {

// Many views from one position, and which of them see a point. The same tests as
// VisibilityEngine::IsInView and ProjectionRatio, but what the views share is computed once: the
// vector to the point for all, its turn to a heading for all pitches.
class ViewFan {
 public:
  ViewFan(const SearchContext& context, const std::vector<ViewDirection>& directions);

  // Whether the point is near enough and faces `position`: cheap, and needed for LookAt.
  bool IsInReach(const Eigen::Vector3d& position, const Eigen::Vector3d& point,
                 const Eigen::Vector3d& normal) const;

  // Whether some view from `position` sees the point at >= γ_min, occlusion apart. Fills seen().
  bool LookAt(const Eigen::Vector3d& position, const Eigen::Vector3d& point,
              const Eigen::Vector3d& normal);

  // Of the last point: the index of each direction that sees it, and the projection ratio.
  const std::vector<std::pair<std::size_t, double>>& seen() const { return seen_; }

 private:
  struct Tilt {
    double sin_pitch, cos_pitch;
    std::size_t direction;
  };
  struct Heading {
    double yaw_rad;
    double sin_yaw, cos_yaw;
    std::vector<Tilt> tilts;
  };

  const SearchContext& context_;
  double range_squared_m2_;
  double min_cos_incidence_;
  // Bounds of x/z and y/z in the camera, border taken off.
  double min_x_, max_x_, min_y_, max_y_;
  double max_abs_x_;
  std::vector<Heading> headings_;
  std::vector<std::pair<std::size_t, double>> seen_;
};

}  // namespace colmap_ext
