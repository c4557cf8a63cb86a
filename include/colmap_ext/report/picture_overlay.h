// What is drawn over a picture: lines and points in the world, hidden where something stands before
// them, and text.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/report/mesh_picture.h"

namespace colmap_ext {

using Polyline3d = std::vector<Eigen::Vector3d>;  // world

struct StrokeStyle {
  Rgb color = {0, 0, 0};
  double width_px = 2;
  double opacity = 1;            // 0 … 1
  double hidden_opacity = 0.25;  // of what lies behind the surface, 0 … 1
  double halo_px = 0;            // white border on each side, where visible
};

// Antialiased, one stroke for all lines: where they cross, nothing is drawn twice.
void DrawPolylines(const std::vector<Polyline3d>& lines, const StrokeStyle& style,
                   Picture* picture);

// Edges of a camera's viewing pyramid, its image rectangle `depth_m` away, with a mark on its upper
// edge.
std::vector<Polyline3d> FrustumLines(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                                     double depth_m);

// Fills a convex planar outline.
void FillPolygon(const Polyline3d& outline, const Rgb& color, double opacity, Picture* picture);

// Points as small shaded discs of `radius_m`, seen from either side; those behind the surface or
// another disc are hidden. `normals` are unit; one colour and one normal a point.
void DrawDiscs(const std::vector<Eigen::Vector3d>& points,
               const std::vector<Eigen::Vector3d>& normals, const std::vector<Rgb>& colors,
               double radius_m, Picture* picture);

enum class TextAnchor { kLeft, kCenter, kRight };

// One line of printable ASCII (anything else becomes '?'); `position`: of the anchor, at half the
// height of the capitals. `height_px`: of the capitals. `halo_px`: white border.
void DrawText(const std::string& text, const Eigen::Vector2d& position, double height_px,
              const Rgb& color, TextAnchor anchor, double halo_px, cv::Mat* bgr);
// Width in pixels that DrawText will need.
double TextWidth(const std::string& text, double height_px);

// A round badge with a text in it.
void DrawBadge(const std::string& text, const Eigen::Vector2d& center, double height_px,
               const Rgb& color, cv::Mat* bgr);

// Pixel of a world point; nullopt behind the camera.
std::optional<Eigen::Vector2d> ProjectToPicture(const PictureCamera& camera,
                                                const Eigen::Vector3d& point_in_world);

struct LegendRow {
  Rgb color;
  std::string label;
  std::string value;     // right-aligned
  bool is_line = false;  // swatch: a line instead of a square
};

// A panel in the lower left corner.
void DrawLegend(const std::string& title, const std::vector<LegendRow>& rows, cv::Mat* bgr);

}  // namespace colmap_ext
