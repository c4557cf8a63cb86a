// Pictures of meshes without a display: a small ray-casting renderer.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/geom/transforms.h"

namespace colmap_ext {

// Red, green, blue, each 0 … 1 (sRGB).
using Rgb = Eigen::Vector3f;

struct PictureCamera {
  PinholeCamera camera;
  Rigid3d cam_from_world;
};

// A camera that looks along `direction` and shows all of `points` (world) as large as possible,
// `margin` (0 … 0.45) of the width and height left free on every side. `fov_rad`: horizontal field
// of view, 0.05 … 2. Throws Error without points.
PictureCamera FitCamera(const std::vector<Eigen::Vector3d>& points, const ViewDirection& direction,
                        const cv::Size& size, double margin = 0.05, double fov_rad = 0.6);
PictureCamera FitCamera(const BoundingBox& bounds, const ViewDirection& direction,
                        const cv::Size& size, double margin = 0.05, double fov_rad = 0.6);

// The eight corners of a box.
std::vector<Eigen::Vector3d> CornersOf(const BoundingBox& box);

// Bounds of what lies between the quantiles `tail` and 1 - `tail` (0 … 0.49) along each axis:
// single far vertices do not make the object small. Empty without points.
BoundingBox RobustBounds(const std::vector<Eigen::Vector3d>& points, double tail);

struct PictureOptions {
  Rgb background_top = {0.965f, 0.972f, 0.980f};
  Rgb background_bottom = {0.870f, 0.888f, 0.908f};
  bool shadows = true;                 // of a sun from the upper left, behind the viewer
  double crease_rad = 0.7;             // edges sharper than this are shaded as edges, 0 … pi
  double supersample_contrast = 0.04;  // neighbours that differ more (0 … 1) get 2 x 2 samples
};

// A picture that things can still be drawn into (picture_overlay.h).
struct Picture {
  PictureCamera camera;
  cv::Mat bgr;      // CV_8UC3
  cv::Mat depth_m;  // CV_32F, along the optical axis at pixel centres; +infinity: background
};

// Colour of the surface at a hit. Called from many threads.
using ColorAt = std::function<Rgb(const RayHit& hit, const Eigen::Vector3d& position)>;

ColorAt ConstantColor(const Rgb& color);
// One colour a vertex, interpolated. `mesh` and `colors` must outlive the result.
ColorAt VertexColors(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& colors);
// One colour a face; `colors` must outlive the result.
ColorAt FaceColors(const std::vector<Rgb>& colors);

// A mesh prepared for pictures: several pictures of one mesh share the work.
class MeshPainter {
 public:
  explicit MeshPainter(TriangleMesh mesh_in_world, const PictureOptions& options = {});

  const TriangleMesh& mesh() const { return mesh_; }
  // Both sides of a face are shaded alike. An empty mesh gives the background.
  Picture Render(const ColorAt& color, const PictureCamera& camera) const;

 private:
  struct Sample;
  struct Lights;
  Sample Trace(const ColorAt& color, const PictureCamera& camera, const Lights& lights,
               const Eigen::Vector2d& pixel) const;
  Eigen::Vector3d ShadingNormal(const RayHit& hit) const;
  static Lights LightsFor(const PictureCamera& camera);
  Rgb Background(double share_from_top) const;

  TriangleMesh mesh_;
  PictureOptions options_;
  RayScene scene_;
  double size_m_ = 0;                            // diagonal of the mesh
  std::vector<Eigen::Vector3f> corner_normals_;  // three a face
};

// One picture of one mesh.
Picture RenderMesh(const TriangleMesh& mesh, const ColorAt& color, const PictureCamera& camera,
                   const PictureOptions& options = {});

// Writes a picture as PNG, atomically. Throws Error naming the file.
void WritePng(const cv::Mat& bgr, const std::filesystem::path& path);

}  // namespace colmap_ext
