// Light and colour of a point on a scene's surface.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/textured_scene.h"
#include "sim/ambient_light.h"
#include "sim/texture.h"

namespace colmap_ext {

class Shading {
 public:
  Shading(const TexturedScene& scene, const RenderOptions& options);

  struct Surface {
    int face = 0;
    float u = 0, v = 0;         // barycentric, as Embree's
    Eigen::Vector3f direction;  // of the camera's ray, z = 1 in the camera frame
    float depth = 0;            // m
    float spacing = 0;          // m that one sample spans at this depth
    float level_dither = 1;     // in [1, 2): blends pyramid levels over a pixel's samples
  };

  const Eigen::Vector3f& sun_direction() const { return sun_direction_; }
  // Unit normal of the face, towards the viewer.
  Eigen::Vector3f FacingNormal(int face, const Eigen::Vector3f& direction) const;
  // Cosine of the sun on the surface, 0 when it is turned away. Whether something stands between is
  // for the caller to find out.
  float SunCosine(const Surface& surface) const;
  // Linear light towards the viewer, BGR; `sun` is the cosine, or 0 in shadow.
  Eigen::Vector3f SurfaceRadiance(const Surface& surface, float sun) const;
  Eigen::Vector3f SkyRadiance(const Eigen::Vector3f& direction) const;
  // Display value 0 … 255 of linear light.
  Eigen::Vector3f ToDisplay(const Eigen::Vector3f& radiance) const;

 private:
  struct Face {
    Eigen::Vector3i vertex;
    Eigen::Vector3f normal;  // unit
    Eigen::Vector2f uv[3];
    int material = 0;
    float texels_per_m = 0;
  };
  struct Vertex {
    Eigen::Vector3f normal;
    AmbientLight ambient;
  };
  struct Paint {
    std::optional<MipTexture> texture;
    Eigen::Vector3f flat;
  };

  Eigen::Vector3f Albedo(const Face& face, const Surface& surface, float cosine) const;

  RenderOptions options_;
  Eigen::Vector3f sun_direction_;
  Eigen::Vector3f sun_light_, sky_light_, bounce_light_;  // BGR, linear
  std::vector<Face> faces_;
  std::vector<Vertex> vertices_;
  std::vector<Paint> paints_;
};

}  // namespace colmap_ext
