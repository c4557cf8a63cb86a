#include "sim/ray_packets.h"

#include "colmap_ext/util/error.h"

namespace colmap_ext {

PacketScene::PacketScene(const TriangleMesh& mesh) {
  device_ = rtcNewDevice("threads=1");
  if (device_ == nullptr) throw Error("Embree could not be started");
  scene_ = rtcNewScene(device_);
  // Robust: no ray slips through the edge shared by two triangles.
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.faces.size()));
  if (vertices == nullptr || indices == nullptr) throw Error("not enough memory for the scene");
  for (const auto& vertex : mesh.vertices) {
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(vertex[k]);
  }
  for (const auto& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) *indices++ = static_cast<unsigned>(face[k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
}

PacketScene::~PacketScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void PacketScene::Intersect(const int* valid, RTCRayHit16* rays) const {
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene_, rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene_, &context, rays);
#endif
}

void PacketScene::Occluded(const int* valid, RTCRay16* rays) const {
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, scene_, rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid, scene_, &context, rays);
#endif
}

}  // namespace colmap_ext
