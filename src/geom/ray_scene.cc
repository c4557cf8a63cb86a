#include "colmap_ext/geom/ray_scene.h"

#if COLMAP_EXT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <limits>
#include <string>

#include "colmap_ext/geom/closest_point.h"
#include "colmap_ext/geom/embree_scene.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {

struct RayScene::Impl {
  explicit Impl(const TriangleMesh& mesh) : embree(mesh), num_faces(mesh.faces.size()) {}

  EmbreeScene embree;
  std::size_t num_faces = 0;

  Eigen::Vector3d Vertex(unsigned face, unsigned corner) const {
    const float* v =
        embree.vertices() + std::size_t{3} * embree.indices()[std::size_t{3} * face + corner];
    return Eigen::Vector3f(v[0], v[1], v[2]).cast<double>();
  }
};

RayScene::RayScene(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

std::size_t RayScene::NumFaces() const { return impl_->num_faces; }

namespace {

RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double min_m,
               double max_m) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(min_m);
  ray.tfar = static_cast<float>(max_m);
  ray.mask = ~0U;
  return ray;
}

}  // namespace

std::optional<RayHit> RayScene::Intersect(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double min_m,
                                          double max_m) const {
  RTCRayHit query{};
  query.ray = MakeRay(origin, direction, min_m, max_m);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  rtcIntersect1(impl_->embree.get(), &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->embree.get(), &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return RayHit{static_cast<double>(query.ray.tfar), static_cast<int>(query.hit.primID),
                static_cast<double>(query.hit.u), static_cast<double>(query.hit.v)};
}

bool RayScene::IsOccluded(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                          double epsilon_m) const {
  const Eigen::Vector3d offset = to - from;
  const double length = offset.norm();
  if (length <= 2 * epsilon_m) return false;
  RTCRay ray = MakeRay(from, offset / length, epsilon_m, length - epsilon_m);
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  rtcOccluded1(impl_->embree.get(), &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->embree.get(), &context, &ray);
#endif
  return ray.tfar < 0;  // Embree's sign for "hit"
}

namespace {

struct DistanceQuery {
  const void* impl;
  Eigen::Vector3d point;
};

}  // namespace

double RayScene::DistanceToSurface(const Eigen::Vector3d& point, double max_m) const {
  if (impl_->num_faces == 0 || !(max_m > 0)) return max_m;
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x());
  query.y = static_cast<float>(point.y());
  query.z = static_cast<float>(point.z());
  query.radius =
      std::isfinite(max_m) ? static_cast<float>(max_m) : std::numeric_limits<float>::max();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  DistanceQuery user{impl_.get(), point};
  rtcPointQuery(
      impl_->embree.get(), &query, &context,
      [](RTCPointQueryFunctionArguments* arguments) {
        const auto* data = static_cast<const DistanceQuery*>(arguments->userPtr);
        const auto* impl = static_cast<const Impl*>(data->impl);
        const Eigen::Vector3d closest = ClosestPointOnTriangle(
            data->point, impl->Vertex(arguments->primID, 0), impl->Vertex(arguments->primID, 1),
            impl->Vertex(arguments->primID, 2));
        const float distance = static_cast<float>((closest - data->point).norm());
        if (distance >= arguments->query->radius) return false;
        arguments->query->radius = distance;
        return true;
      },
      &user);
  const double found = static_cast<double>(query.radius);
  return std::isfinite(max_m) ? std::min(found, max_m) : found;
}

}  // namespace colmap_ext
