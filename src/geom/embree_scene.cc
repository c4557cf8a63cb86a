#include "colmap_ext/geom/embree_scene.h"

#if COLMAP_EXT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <tbb/task_arena.h>

#include <new>
#include <string>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

struct ReleaseScene {
  void operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }
};

struct ReleaseGeometry {
  void operator()(RTCGeometryTy* geometry) const { rtcReleaseGeometry(geometry); }
};

// Embree gives errors by return value: unnoticed, rays would miss everything. `device` may be null:
// the error of making one.
void ThrowIfFailed(RTCDevice device, const char* doing) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) {
    throw Error(std::string("Embree cannot ") + doing + " (its error " +
                std::to_string(static_cast<int>(error)) + "); is there enough memory?");
  }
}

}  // namespace

void EmbreeScene::Release::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }

// A device that is told a number of threads holds all of TBB to it, for as long as it lives.
EmbreeScene::EmbreeScene(const TriangleMesh& mesh) : device_(rtcNewDevice(nullptr)) {
  if (device_ == nullptr) {
    ThrowIfFailed(nullptr, "be started");
    throw Error("Embree cannot be started");
  }
  std::unique_ptr<RTCSceneTy, ReleaseScene> scene(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  if (!mesh.faces.empty()) {
    const std::unique_ptr<RTCGeometryTy, ReleaseGeometry> geometry(
        rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.faces.size()));
    if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
    vertices_ = vertices;
    indices_ = indices;
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(vertex[k]);
    }
    for (const Eigen::Vector3i& face : mesh.faces) {
      for (int k = 0; k < 3; ++k) *indices++ = static_cast<unsigned>(face[k]);
    }
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
  }
  // By one thread: the same tree every time, and so the same hit where two faces are equally near.
  tbb::task_arena(1).execute([&] { rtcCommitScene(scene.get()); });
  ThrowIfFailed(device_.get(), "index the mesh");
  scene_ = scene.release();
}

EmbreeScene::~EmbreeScene() { rtcReleaseScene(scene_); }

}  // namespace colmap_ext
