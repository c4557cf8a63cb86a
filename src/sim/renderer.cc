#include "colmap_ext/sim/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "sim/camera_rays.h"
#include "sim/noise.h"
#include "sim/ray_packets.h"
#include "sim/shading.h"

namespace colmap_ext {
namespace {

constexpr int kTile = 16;  // px

void CheckCamera(const PinholeCamera& camera) {
  if (camera.width < 1 || camera.height < 1 || !(camera.fx > 0) || !(camera.fy > 0) ||
      !std::isfinite(camera.cx) || !std::isfinite(camera.cy)) {
    throw Error("camera to render with needs a size and focal lengths greater than 0");
  }
}

// Calls `tile(x0, y0, x1, y1)` (px) for all tiles of a picture, in parallel.
template <typename Function>
void ForEachTile(const PinholeCamera& camera, const Function& tile) {
  const int columns = (camera.width + kTile - 1) / kTile;
  const int rows = (camera.height + kTile - 1) / kTile;
  ParallelFor(columns * rows, [&](int index) {
    const int x0 = index % columns * kTile, y0 = index / columns * kTile;
    tile(x0, y0, std::min(x0 + kTile, camera.width), std::min(y0 + kTile, camera.height));
  });
}

struct alignas(64) Packet {
  RTCRayHit16 rays;
  RTCRay16 shadow_rays;
  alignas(64) std::array<int, PacketScene::kWidth> valid;
  alignas(64) std::array<int, PacketScene::kWidth> shadow_valid;
  std::array<Shading::Surface, PacketScene::kWidth> surface;
  std::array<float, PacketScene::kWidth> sun;
};

Eigen::Vector3f DirectionOf(const RTCRay16& ray, int lane) {
  return {ray.dir_x[lane], ray.dir_y[lane], ray.dir_z[lane]};
}

}  // namespace

struct Renderer::Impl {
  Impl(const TexturedScene& scene, const RenderOptions& render_options)
      : options(render_options), mesh(scene.mesh), packets(scene.mesh), shading(scene, options) {}

  void FindSurfaces(const CameraRays& rays, int i0, int j0, Packet* packet) const;
  void FindShadows(Packet* packet) const;
  void RenderTile(const CameraRays& rays, std::uint32_t noise_seed, const cv::Rect& tile,
                  cv::Mat* picture) const;
  cv::Vec3b Pixel(const Eigen::Vector3f& radiance, std::uint32_t noise_hash) const;

  RenderOptions options;
  TriangleMesh mesh;
  PacketScene packets;
  Shading shading;
};

void Renderer::Impl::FindSurfaces(const CameraRays& rays, int i0, int j0, Packet* packet) const {
  rays.FillPacket(i0, j0, &packet->rays, packet->valid.data());
  packets.Intersect(packet->valid.data(), &packet->rays);
  const int per_pixel = rays.samples_per_axis() * rays.samples_per_axis();
  for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    Shading::Surface& surface = packet->surface[l];
    packet->sun[l] = 0;
    surface.face = -1;
    surface.direction = DirectionOf(packet->rays.ray, lane);
    if (packet->valid[l] == 0 || packet->rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
      continue;
    }
    surface.face = static_cast<int>(packet->rays.hit.primID[lane]);
    surface.u = packet->rays.hit.u[lane];
    surface.v = packet->rays.hit.v[lane];
    surface.depth = packet->rays.ray.tfar[lane];
    surface.spacing = surface.depth * rays.SampleSpacing();
    const int index =
        rays.IndexInPixel(i0 + lane % CameraRays::kBlock, j0 + lane / CameraRays::kBlock);
    surface.level_dither = 1 + (static_cast<float>(index) + 0.5F) / static_cast<float>(per_pixel);
    packet->sun[l] = shading.SunCosine(surface);
  }
}

// Clears `sun` of the lanes between whose surface and the sun something stands.
void Renderer::Impl::FindShadows(Packet* packet) const {
  bool any = false;
  RTCRay16& shadow = packet->shadow_rays;
  const RTCRay16& ray = packet->rays.ray;
  for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    const bool lit = packet->sun[l] > 0;
    packet->shadow_valid[l] = lit ? -1 : 0;
    if (!lit) continue;
    any = true;
    const Shading::Surface& surface = packet->surface[l];
    // Off the surface by more than the error of the hit in float32.
    const Eigen::Vector3f offset =
        (5e-4F + 5e-5F * surface.depth) * shading.FacingNormal(surface.face, surface.direction);
    shadow.org_x[lane] = ray.org_x[lane] + surface.depth * ray.dir_x[lane] + offset.x();
    shadow.org_y[lane] = ray.org_y[lane] + surface.depth * ray.dir_y[lane] + offset.y();
    shadow.org_z[lane] = ray.org_z[lane] + surface.depth * ray.dir_z[lane] + offset.z();
    shadow.dir_x[lane] = shading.sun_direction().x();
    shadow.dir_y[lane] = shading.sun_direction().y();
    shadow.dir_z[lane] = shading.sun_direction().z();
    shadow.tnear[lane] = 0;
    shadow.tfar[lane] = 1e5F;
    shadow.time[lane] = 0;
    shadow.mask[lane] = ~0U;
    shadow.id[lane] = 0;
    shadow.flags[lane] = 0;
  }
  if (!any) return;
  packets.Occluded(packet->shadow_valid.data(), &shadow);
  for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    if (packet->shadow_valid[l] != 0 && shadow.tfar[lane] < 0) packet->sun[l] = 0;
  }
}

cv::Vec3b Renderer::Impl::Pixel(const Eigen::Vector3f& radiance, std::uint32_t hash) const {
  Eigen::Vector3f value = shading.ToDisplay(radiance);
  if (options.sensor_noise_sigma > 0) {
    for (std::uint32_t k = 0; k < 3; ++k) {  // Box and Muller
      const float radius = std::sqrt(-2 * std::log(std::max(1e-7F, HashUnit(hash, 2 * k))));
      const float turn = 6.2831853F * HashUnit(hash, 2 * k + 1);
      value[static_cast<int>(k)] +=
          static_cast<float>(options.sensor_noise_sigma) * radius * std::cos(turn);
    }
  }
  const auto byte = [](float v) {
    return static_cast<unsigned char>(std::clamp(v, 0.0F, 255.0F) + 0.5F);
  };
  return {byte(value[0]), byte(value[1]), byte(value[2])};
}

void Renderer::Impl::RenderTile(const CameraRays& rays, std::uint32_t noise_seed,
                                const cv::Rect& tile, cv::Mat* picture) const {
  const int n = rays.samples_per_axis();
  std::vector<Eigen::Vector3f> sum(static_cast<std::size_t>(tile.area()), Eigen::Vector3f::Zero());
  Packet packet;
  for (int j0 = tile.y * n; j0 < tile.br().y * n; j0 += CameraRays::kBlock) {
    for (int i0 = tile.x * n; i0 < tile.br().x * n; i0 += CameraRays::kBlock) {
      FindSurfaces(rays, i0, j0, &packet);
      if (options.shadows) FindShadows(&packet);
      for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
        const auto l = static_cast<std::size_t>(lane);
        if (packet.valid[l] == 0) continue;
        const int x = (i0 + lane % CameraRays::kBlock) / n - tile.x;
        const int y = (j0 + lane / CameraRays::kBlock) / n - tile.y;
        if (x >= tile.width || y >= tile.height) continue;
        const Shading::Surface& surface = packet.surface[l];
        sum[static_cast<std::size_t>(y * tile.width + x)] +=
            surface.face < 0 ? shading.SkyRadiance(surface.direction)
                             : shading.SurfaceRadiance(surface, packet.sun[l]);
      }
    }
  }
  const float weight = 1.0F / static_cast<float>(n * n);
  for (int y = 0; y < tile.height; ++y) {
    auto* row = picture->ptr<cv::Vec3b>(tile.y + y) + tile.x;
    for (int x = 0; x < tile.width; ++x) {
      const Eigen::Vector3f radiance = weight * sum[static_cast<std::size_t>(y * tile.width + x)];
      row[x] = Pixel(radiance, HashOf(tile.x + x, tile.y + y, 11, noise_seed));
    }
  }
}

Renderer::Renderer(const TexturedScene& scene, const RenderOptions& options) {
  ThrowIfInvalid(options.Check());
  CheckScene(scene, "scene to render");
  impl_ = std::make_unique<Impl>(scene, options);
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

cv::Mat Renderer::Render(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                         std::uint64_t noise_seed, const CameraMotion& motion) const {
  CheckCamera(camera);
  const int n = static_cast<int>(std::lround(std::sqrt(impl_->options.samples_per_pixel)));
  const CameraRays rays(camera, cam_from_world, n, motion, impl_->options.shutter_s);
  const std::uint32_t seed = HashBits(static_cast<std::uint32_t>(noise_seed)) ^
                             static_cast<std::uint32_t>(noise_seed >> 32);
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  ForEachTile(camera, [&](int x0, int y0, int x1, int y1) {
    impl_->RenderTile(rays, seed, {x0, y0, x1 - x0, y1 - y0}, &picture);
  });
  return picture;
}

cv::Mat Renderer::RenderFaces(const PinholeCamera& camera, const Rigid3d& cam_from_world) const {
  CheckCamera(camera);
  const CameraRays rays(camera, cam_from_world, 1, {}, 0);
  cv::Mat faces(camera.height, camera.width, CV_32SC1, cv::Scalar(-1));
  ForEachTile(camera, [&](int x0, int y0, int x1, int y1) {
    Packet packet;
    for (int y = y0; y < y1; y += CameraRays::kBlock) {
      for (int x = x0; x < x1; x += CameraRays::kBlock) {
        rays.FillPacket(x, y, &packet.rays, packet.valid.data());
        impl_->packets.Intersect(packet.valid.data(), &packet.rays);
        for (int lane = 0; lane < PacketScene::kWidth; ++lane) {
          if (packet.valid[static_cast<std::size_t>(lane)] == 0 ||
              packet.rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
            continue;
          }
          faces.at<int>(y + lane / CameraRays::kBlock, x + lane % CameraRays::kBlock) =
              static_cast<int>(packet.rays.hit.primID[lane]);
        }
      }
    }
  });
  return faces;
}

cv::Mat Renderer::RenderDepth(const PinholeCamera& camera, const Rigid3d& cam_from_world) const {
  const cv::Mat faces = RenderFaces(camera, cam_from_world);
  const Eigen::Vector3d center = CameraCenter(cam_from_world);
  const Eigen::Matrix3d world_from_cam = cam_from_world.rotation.toRotationMatrix().transpose();
  cv::Mat depth(camera.height, camera.width, CV_32FC1, cv::Scalar(0));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const int index = faces.at<int>(y, x);
      if (index < 0) continue;
      // The ray's point with z = 1 meets the triangle's plane at n·(v0 - c) / n·d.
      const auto face = static_cast<std::size_t>(index);
      const Eigen::Vector3d normal = FaceNormal(impl_->mesh, face);
      const auto v0 = static_cast<std::size_t>(impl_->mesh.faces[face][0]);
      const Eigen::Vector3d direction = world_from_cam * camera.Ray({x + 0.5, y + 0.5});
      depth.at<float>(y, x) =
          static_cast<float>(normal.dot(impl_->mesh.vertices[v0] - center) / normal.dot(direction));
    }
  }
  return depth;
}

}  // namespace colmap_ext
