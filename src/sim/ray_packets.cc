#include "sim/ray_packets.h"

namespace colmap_ext {

PacketScene::PacketScene(const TriangleMesh& mesh) : embree_(mesh) {}

void PacketScene::Intersect(const int* valid, RTCRayHit16* rays) const {
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, embree_.get(), rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, embree_.get(), &context, rays);
#endif
}

void PacketScene::Occluded(const int* valid, RTCRay16* rays) const {
#if COLMAP_EXT_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, embree_.get(), rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid, embree_.get(), &context, rays);
#endif
}

}  // namespace colmap_ext
