// Small scenes with known answers.
#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext::test {

// Appends the parallelogram origin, origin + a, origin + b (outside a x b) with texture coordinates
// (0, 0) at the origin, u along a.
inline void AddQuad(const Eigen::Vector3d& origin, const Eigen::Vector3d& a,
                    const Eigen::Vector3d& b, int material, int object, TexturedScene* scene) {
  const auto first = static_cast<int>(scene->mesh.vertices.size());
  const Eigen::Vector3f normal = a.cross(b).normalized().cast<float>();
  for (const Eigen::Vector3d& p : {origin, Eigen::Vector3d(origin + a),
                                   Eigen::Vector3d(origin + a + b), Eigen::Vector3d(origin + b)}) {
    scene->mesh.vertices.push_back(p);
    scene->vertex_normals.push_back(normal);
  }
  const Eigen::Vector2f uv[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  scene->mesh.faces.emplace_back(first, first + 1, first + 2);
  scene->corner_uv.push_back({uv[0], uv[1], uv[2]});
  scene->mesh.faces.emplace_back(first, first + 2, first + 3);
  scene->corner_uv.push_back({uv[0], uv[2], uv[3]});
  for (int i = 0; i < 2; ++i) {
    scene->material_of_face.push_back(material);
    scene->object_of_face.push_back(object);
  }
}

// Axis-aligned cube, all six sides outwards.
inline void AddCube(const Eigen::Vector3d& low, double size, int material, int object,
                    TexturedScene* scene) {
  const Eigen::Vector3d x(size, 0, 0), y(0, size, 0), z(0, 0, size);
  AddQuad(low, x, z, material, object, scene);
  AddQuad(low + x, y, z, material, object, scene);
  AddQuad(low + x + y, -x, z, material, object, scene);
  AddQuad(low + y, -y, z, material, object, scene);
  AddQuad(low + z, x, y, material, object, scene);
  AddQuad(low + y, x, -y, material, object, scene);
}

inline Material FlatMaterial(float grey) {
  Material material;
  material.name = "flat";
  material.flat_bgr = Eigen::Vector3f::Constant(grey);
  return material;
}

// Ground of 40 x 40 m at z = 0.
inline TexturedScene GroundScene(const Material& material) {
  TexturedScene scene;
  scene.materials.push_back(material);
  AddQuad({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 0, kGroundObject, &scene);
  return scene;
}

// No light that depends on place, so that colours are those of the materials.
inline RenderOptions PlainLight() {
  RenderOptions options;
  options.shadows = false;
  options.sun_strength = 0;
  options.ambient_rays = 0;
  return options;
}

inline PinholeCamera SmallCamera() { return {160, 92, 120, 120, 80, 46}; }

inline Rigid3d LookingDown(const Eigen::Vector3d& from) {
  return CamFromWorld(from, {0, DegToRad(-90)});
}

// A folder that is empty at the start and gone at the end.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() /
              ("colmap_ext_sim_" + name + "_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Keeps warnings.
class RecordingSink : public ProgressSink {
 public:
  void Message(LogLevel level, std::string_view text) override {
    if (level == LogLevel::kWarning) warnings.emplace_back(text);
  }
  void Progress(std::string_view, std::size_t, std::size_t) override {}
  std::vector<std::string> warnings;
};

// The message of the Error that `function` throws, or "" when it throws none.
template <typename Function>
std::string ErrorOf(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace colmap_ext::test
