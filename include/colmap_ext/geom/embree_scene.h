// A mesh as Embree holds it: for those who cast rays themselves. Most want RayScene.
#pragma once

#include <memory>

#include "colmap_ext/geom/mesh.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace colmap_ext {

// Committed and robust: no ray slips through the edge shared by two triangles. Triangle `i` of the
// only geometry is face `i`. Immutable after construction; may be asked from many threads.
class EmbreeScene {
 public:
  // A mesh without faces gives a scene that no ray hits. Throws Error when Embree does not start or
  // has not enough memory.
  explicit EmbreeScene(const TriangleMesh& mesh);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // Embree's RTCScene; owned by this object.
  RTCSceneTy* get() const { return scene_; }
  // Embree's own copy of the mesh: 3 floats a vertex, 3 indices a face; null without faces.
  const float* vertices() const { return vertices_; }
  const unsigned* indices() const { return indices_; }

 private:
  struct Release {
    void operator()(RTCDeviceTy* device) const;
  };
  std::unique_ptr<RTCDeviceTy, Release> device_;  // goes after the scene
  RTCSceneTy* scene_ = nullptr;
  const float* vertices_ = nullptr;
  const unsigned* indices_ = nullptr;
};

}  // namespace colmap_ext
