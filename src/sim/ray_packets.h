// Coherent rays in packets of 16 (Embree), for rendering. Versions 3 and 4 of Embree differ in
// names.
#pragma once

#if COLMAP_EXT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

class PacketScene {
 public:
  static constexpr int kWidth = 16;

  explicit PacketScene(const TriangleMesh& mesh);
  ~PacketScene();
  PacketScene(const PacketScene&) = delete;
  PacketScene& operator=(const PacketScene&) = delete;

  // First hits of the lanes whose `valid` is -1; see rtcIntersect16.
  void Intersect(const int* valid, RTCRayHit16* rays) const;
  // Lanes that hit something get tfar = -infinity; see rtcOccluded16.
  void Occluded(const int* valid, RTCRay16* rays) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace colmap_ext
