#include "colmap_ext/sim/textured_scene.h"

#include <cmath>

#include "colmap_ext/util/error.h"
#include "sim/face_visibility.h"
#include "sim/scenes.h"

namespace colmap_ext {
namespace {

void Require(bool fine, const std::string& where, const std::string& what) {
  if (!fine) throw Error(where + ": " + what);
}

}  // namespace

GroundTruth TexturedScene::Truth() const {
  GroundTruth truth;
  truth.origin = origin;
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (IsGround(i)) continue;
    Eigen::Vector3i face = mesh.faces[i];
    for (int k = 0; k < 3; ++k) {
      int& index = new_index[static_cast<std::size_t>(face[k])];
      if (index < 0) {
        index = static_cast<int>(truth.model.vertices.size());
        truth.model.vertices.push_back(mesh.vertices[static_cast<std::size_t>(face[k])]);
      }
      face[k] = index;
    }
    truth.model.faces.push_back(face);
  }
  return truth;
}

void CheckScene(const TexturedScene& scene, const std::string& where) {
  const std::size_t faces = scene.mesh.faces.size();
  const auto vertices = static_cast<int>(scene.mesh.vertices.size());
  const auto materials = static_cast<int>(scene.materials.size());
  Require(faces > 0, where, "holds no triangle");
  Require(scene.vertex_normals.size() == scene.mesh.vertices.size(), where,
          "needs one normal a vertex");
  Require(scene.corner_uv.size() == faces && scene.material_of_face.size() == faces &&
              scene.object_of_face.size() == faces,
          where, "needs texture coordinates, material and object for each face");
  for (const auto& vertex : scene.mesh.vertices) {
    Require(vertex.allFinite(), where, "has a vertex that is not finite");
  }
  for (std::size_t i = 0; i < faces; ++i) {
    const auto& face = scene.mesh.faces[i];
    Require(face.minCoeff() >= 0 && face.maxCoeff() < vertices, where,
            "face " + std::to_string(i) + " points to a vertex that is not there");
    Require(scene.material_of_face[i] >= 0 && scene.material_of_face[i] < materials, where,
            "face " + std::to_string(i) + " has a material that is not there");
    for (const auto& uv : scene.corner_uv[i]) {
      Require(uv.allFinite(), where,
              "face " + std::to_string(i) + " has texture coordinates that are not finite");
    }
  }
}

TexturedScene MakeScene(const std::string& name, std::uint64_t seed, double texel_scale) {
  if (!(texel_scale >= 0.5 && texel_scale <= 16)) {
    throw UsageError("texel scale must be in [0.5, 16]");
  }
  if (name == "church") return MakeChurch(seed, texel_scale);
  if (name == "gate") return MakeGate(seed, texel_scale);
  if (name == "boxes") return MakeBoxes(seed, texel_scale);
  throw UsageError("unknown scene '" + name + "': use church, boxes or gate");
}

}  // namespace colmap_ext
