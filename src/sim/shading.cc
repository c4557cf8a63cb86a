#include "sim/shading.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace colmap_ext {
namespace {

// Display values are square roots of light (gamma 2), in both directions.
constexpr float kWhiteAlbedo = 0.92F;
constexpr float kHazeDistance = 1500;  // m
const Eigen::Vector3f kHaze(0.80F, 0.72F, 0.66F);
const Eigen::Vector3f kZenith(0.95F, 0.50F, 0.26F);
const Eigen::Vector3f kHorizon(1.05F, 0.92F, 0.80F);

Eigen::Vector3f FromSun(const RenderOptions& options) {
  const double azimuth = DegToRad(options.sun_azimuth_deg);
  const double elevation = DegToRad(options.sun_elevation_deg);
  return Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                         std::cos(azimuth) * std::cos(elevation), std::sin(elevation))
      .cast<float>();
}

float TexelsPerMetre(const TexturedScene& scene, std::size_t i, double world_area) {
  const auto& material = scene.materials[static_cast<std::size_t>(scene.material_of_face[i])];
  if (material.texture_bgr.empty() || world_area <= 0) return 0;
  const auto& uv = scene.corner_uv[i];
  const Eigen::Vector2f a = uv[1] - uv[0], b = uv[2] - uv[0];
  const double area = 0.5 * std::abs(static_cast<double>(a.x() * b.y() - a.y() * b.x())) *
                      material.texture_bgr.cols * material.texture_bgr.rows;
  return static_cast<float>(std::sqrt(area / world_area));
}

}  // namespace

Shading::Shading(const TexturedScene& scene, const RenderOptions& options)
    : options_(options), sun_direction_(FromSun(options)) {
  const auto sun = static_cast<float>(options.sun_strength);
  const auto sky = static_cast<float>(options.sky_strength);
  sun_light_ = Eigen::Vector3f(1.42F, 1.66F, 1.80F) * sun;
  sky_light_ = Eigen::Vector3f(0.86F, 0.70F, 0.58F) * sky;
  // What comes back from sunlit ground and walls.
  bounce_light_ = Eigen::Vector3f(0.20F, 0.26F, 0.28F) * sky;

  const auto ambient = ComputeAmbientLight(scene, options.ambient_rays);
  for (std::size_t i = 0; i < ambient.size(); ++i) {
    vertices_.push_back({scene.vertex_normals[i], ambient[i]});
  }
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) {
    Face face;
    face.vertex = scene.mesh.faces[i];
    face.normal = FaceNormal(scene.mesh, i).cast<float>();
    for (std::size_t k = 0; k < 3; ++k) face.uv[k] = scene.corner_uv[i][k];
    face.material = scene.material_of_face[i];
    face.texels_per_m = TexelsPerMetre(scene, i, FaceArea(scene.mesh, i));
    faces_.push_back(face);
  }
  for (const Material& material : scene.materials) {
    Paint paint;
    paint.flat = material.flat_bgr;
    if (!material.texture_bgr.empty()) paint.texture.emplace(material.texture_bgr);
    paints_.push_back(std::move(paint));
  }
}

Eigen::Vector3f Shading::FacingNormal(int face, const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f& normal = faces_[static_cast<std::size_t>(face)].normal;
  return normal.dot(direction) > 0 ? Eigen::Vector3f(-normal) : normal;
}

float Shading::SunCosine(const Surface& s) const {
  const Face& face = faces_[static_cast<std::size_t>(s.face)];
  const float side = face.normal.dot(s.direction) > 0 ? -1.0F : 1.0F;
  if (side * face.normal.dot(sun_direction_) <= 0) return 0;
  const auto normal_at = [&](int k) -> const Eigen::Vector3f& {
    return vertices_[static_cast<std::size_t>(face.vertex[k])].normal;
  };
  const Eigen::Vector3f normal =
      ((1 - s.u - s.v) * normal_at(0) + s.u * normal_at(1) + s.v * normal_at(2)).normalized();
  return std::max(0.0F, side * normal.dot(sun_direction_));
}

Eigen::Vector3f Shading::Albedo(const Face& face, const Surface& s, float cosine) const {
  const Paint& paint = paints_[static_cast<std::size_t>(face.material)];
  Eigen::Vector3f color = paint.flat;
  if (paint.texture.has_value()) {
    const Eigen::Vector2f uv = (1 - s.u - s.v) * face.uv[0] + s.u * face.uv[1] + s.v * face.uv[2];
    // A sample's footprint is long along the slope and short across: the level lies in between.
    const float texels =
        s.spacing * face.texels_per_m / std::sqrt(std::max(cosine, 0.05F)) * s.level_dither;
    const auto bits = std::bit_cast<std::uint32_t>(std::max(texels, 1.0F));
    const int level = static_cast<int>(bits >> 23) - 127;  // floor(log2)
    color = paint.texture->Sample(uv.x(), uv.y(), level);
  }
  color *= 1.0F / 255.0F;
  return kWhiteAlbedo * color.cwiseProduct(color);
}

Eigen::Vector3f Shading::SurfaceRadiance(const Surface& s, float sun) const {
  const Face& face = faces_[static_cast<std::size_t>(s.face)];
  const auto ambient_at = [&](int k) -> const AmbientLight& {
    return vertices_[static_cast<std::size_t>(face.vertex[k])].ambient;
  };
  const float w = 1 - s.u - s.v;
  const float sky = w * ambient_at(0).sky + s.u * ambient_at(1).sky + s.v * ambient_at(2).sky;
  const float bounce =
      w * ambient_at(0).bounce + s.u * ambient_at(1).bounce + s.v * ambient_at(2).bounce;
  const Eigen::Vector3f light = sun * sun_light_ + sky * sky_light_ + bounce * bounce_light_;
  const float cosine = std::abs(face.normal.dot(s.direction)) / s.direction.norm();
  const Eigen::Vector3f radiance = Albedo(face, s, cosine).cwiseProduct(light);
  const float haze = s.depth / (s.depth + kHazeDistance);
  return radiance + haze * (kHaze - radiance);
}

Eigen::Vector3f Shading::SkyRadiance(const Eigen::Vector3f& direction) const {
  const float up = direction.z() / direction.norm();
  if (up < 0) return kHaze + (kHorizon - kHaze) * std::max(0.0F, 1 + 20 * up);
  const float t = 1 - (1 - up) * (1 - up) * (1 - up);
  return kHorizon + t * (kZenith - kHorizon);
}

Eigen::Vector3f Shading::ToDisplay(const Eigen::Vector3f& radiance) const {
  const Eigen::Array3f x = radiance.array().max(0.0F) * static_cast<float>(options_.exposure);
  // Highlights run out softly: 2 is white (Reinhard's curve).
  const Eigen::Array3f soft = x * (1 + x / 4) / (1 + 0.5F * x);
  return (255.0F * soft.min(1.0F).sqrt()).matrix();
}

}  // namespace colmap_ext
