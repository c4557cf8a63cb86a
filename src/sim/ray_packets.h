// Coherent rays in packets of 16 (Embree), for rendering. Versions 3 and 4 of Embree differ in
// names.
#pragma once

#if COLMAP_EXT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include "colmap_ext/geom/embree_scene.h"
#include "colmap_ext/geom/mesh.h"

namespace colmap_ext {

class PacketScene {
 public:
  static constexpr int kWidth = 16;

  explicit PacketScene(const TriangleMesh& mesh);

  // First hits of the lanes whose `valid` is -1; see rtcIntersect16.
  void Intersect(const int* valid, RTCRayHit16* rays) const;
  // Lanes that hit something get tfar = -infinity; see rtcOccluded16.
  void Occluded(const int* valid, RTCRay16* rays) const;

 private:
  EmbreeScene embree_;
};

}  // namespace colmap_ext
