// Builds textured scenes from planar polygons, grids and prisms. Every piece of surface gets a
// chart: a rectangle of its own in its material's texture, painted once all charts are known, so
// that no texture repeats.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/sim/textured_scene.h"

namespace colmap_ext {

using Polygon2d = std::vector<Eigen::Vector2d>;

// What a painter knows of a texel.
struct SurfacePoint {
  Eigen::Vector2f uv;      // m, in the chart's pattern coordinates (coplanar neighbours continue)
  Eigen::Vector3f world;   // m
  Eigen::Vector2f chart;   // m, from the chart's lower left corner
  Eigen::Vector2f size;    // m, of the chart
  std::uint32_t seed = 0;  // differs from chart to chart
};
// Colour of a surface, RGB 0 … 1 (display values). Must be a pure function: called from many
// threads.
using Painter = std::function<Eigen::Vector3f(const SurfacePoint&)>;

// A plane with axes: origin + a u + b v; u and v are orthonormal, the outside is u x v.
struct PlaneFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d v = Eigen::Vector3d::UnitZ();

  Eigen::Vector3d Normal() const { return u.cross(v); }
  Eigen::Vector3d At(double a, double b, double out = 0) const {
    return origin + a * u + b * v + out * Normal();
  }
  Eigen::Vector3d At(const Eigen::Vector2d& p, double out = 0) const {
    return At(p.x(), p.y(), out);
  }
  // The same plane moved by (a, b, out).
  PlaneFrame Moved(double a, double b, double out = 0) const { return {At(a, b, out), u, v}; }
};

class SceneBuilder {
 public:
  SceneBuilder(std::uint64_t seed, double texel_scale);

  // `texel_m` before the builder's texel scale. Returns the material's index.
  int AddMaterial(const std::string& name, double texel_m, Painter painter);
  // Faces added from now on belong to this object.
  void SetObject(int object) { object_ = object; }
  // Local coordinates of everything added from now on.
  void SetPlacement(const Eigen::Isometry3d& world_from_local) { placement_ = world_from_local; }
  const Eigen::Isometry3d& placement() const { return placement_; }

  // --- the elements ---
  // A chart of `size_m` whose lower left corner has pattern coordinates `pattern_origin`;
  // `local_at` maps chart metres to local coordinates (for painters that look at the place in the
  // world).
  int AddChart(int material, const Eigen::Vector2d& size_m, const Eigen::Vector2d& pattern_origin,
               std::function<Eigen::Vector3d(const Eigen::Vector2d&)> local_at);
  // `chart_m` is relative to the chart's lower left corner. Returns the vertex's index.
  int AddVertex(int chart, const Eigen::Vector3d& local, const Eigen::Vector2d& chart_m);
  void AddTriangle(int a, int b, int c);
  // Ground relief and similar: moves a vertex.
  void Displace(int vertex, const Eigen::Vector3d& offset_in_world);

  // --- surfaces ---
  // Planar polygon (counter-clockwise, in the frame) with holes, meshed with edges up to
  // `max_edge_m`; inner vertices get a smooth relief of `relief_m` along the normal.
  void AddPolygon(int material, const PlaneFrame& frame, const Polygon2d& outer,
                  const std::vector<Polygon2d>& holes, double max_edge_m, double relief_m = 0);
  // Rectangle [0, a] x [0, b] of the frame, as a grid.
  void AddRectangle(int material, const PlaneFrame& frame, double a, double b, double max_edge_m,
                    double relief_m = 0);
  // Grid of nu x nv cells over (s, t) in [0, 1]²: `local_at` gives positions, `chart_at` chart
  // metres within `size_m`. Outside is d/ds x d/dt.
  void AddGrid(int material, int nu, int nv, const Eigen::Vector2d& size_m,
               const std::function<Eigen::Vector3d(double, double)>& local_at,
               const std::function<Eigen::Vector2d(double, double)>& chart_at);
  // Convex or not, the polygon lies in `frame` (the front) and is extruded by `depth_m` backwards.
  // Sides and front; the back only when `with_back`.
  void AddPrism(int material, const PlaneFrame& frame, const Polygon2d& polygon, double depth_m,
                double max_edge_m, bool with_back = false);
  // Strip along an open or closed line in the frame, from the frame's plane `depth_m` backwards.
  // The outside is to the right of the line's direction.
  void AddStrip(int material, const PlaneFrame& frame, const Polygon2d& line, bool closed,
                double depth_m, double max_edge_m);
  // Axis-aligned block in local coordinates.
  void AddBlock(int material, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                double max_edge_m = 0.5);
  // Bar of rectangular section between two points; `up` hints at the section's height direction.
  void AddBar(int material, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double width_m,
              double height_m, const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());
  // Upright solid of revolution around `base` + z: profile (radius, height) from bottom to top.
  void AddTurned(int material, const Eigen::Vector3d& base,
                 const std::vector<Eigen::Vector2d>& profile, int segments);

  // Paints the textures and computes normals. Model faces that see nothing of the outside are left
  // out.
  TexturedScene Finish(const GeoPosition& origin);

 private:
  struct MaterialEntry {
    std::string name;
    double texel_m;
    Painter painter;
  };
  struct Chart {
    int material;
    Eigen::Vector2d size_m;
    Eigen::Vector2d pattern_origin;
    std::function<Eigen::Vector3d(const Eigen::Vector2d&)> world_at;
    bool used = false;
    int x = 0, y = 0, width = 0, height = 0;  // texels, in the material's texture, from above left
  };
  struct Vertex {
    Eigen::Vector3d world;
    int chart;
    Eigen::Vector2d chart_m;
  };

  void AddStripQuad(int material, const PlaneFrame& front, const Eigen::Vector2d& from,
                    const Eigen::Vector2d& to, double depth_m, double max_edge_m);
  void MarkUsedCharts(const std::vector<bool>& keep_face);
  cv::Size PackCharts(int material);
  Eigen::Vector2f TextureCoordinates(int vertex, const std::vector<cv::Size>& sizes) const;
  cv::Mat PaintMaterial(int material, const cv::Size& size) const;
  void PaintChart(const Chart& chart, std::uint32_t seed, cv::Mat* texture) const;

  std::uint32_t seed_;
  double texel_scale_;
  int object_ = kGroundObject;
  Eigen::Isometry3d placement_ = Eigen::Isometry3d::Identity();
  std::vector<MaterialEntry> materials_;
  std::vector<Chart> charts_;
  std::vector<Vertex> vertices_;
  std::vector<Eigen::Vector3i> faces_;
  std::vector<int> object_of_face_;
};

// Points of a rectangle, counter-clockwise from the lower left.
Polygon2d RectanglePolygon(double left, double bottom, double right, double top);

}  // namespace colmap_ext
