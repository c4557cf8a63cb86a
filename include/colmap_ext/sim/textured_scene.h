// A textured triangle scene with exact truth: made by procedure, or read from a model file.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/truth.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Where scenes without a place of their own are put on Earth (the home of PX4's simulators).
inline constexpr GeoPosition kDefaultSceneOrigin{47.397742, 8.545594, 488.0};

// Object id of ground, floors and surrounding walls: everything that is not the model.
inline constexpr int kGroundObject = 0;

struct Material {
  std::string name;
  // CV_8UC3 BGR; the upper row is v = 1 (as in OBJ). Repeats outside [0, 1]. Empty: flat colour.
  cv::Mat texture_bgr;
  Eigen::Vector3f flat_bgr = Eigen::Vector3f(160, 160, 160);  // 0 … 255
};

struct TexturedScene {
  TriangleMesh mesh;  // world (ENU), metres, z up; counter-clockwise seen from outside
  std::vector<Eigen::Vector3f> vertex_normals;  // unit, one a vertex; vertices are split at creases
  std::vector<std::array<Eigen::Vector2f, 3>> corner_uv;  // one a face, texture coordinates
  std::vector<int> material_of_face;
  std::vector<int> object_of_face;  // kGroundObject or 1, 2, … (a part of the model)
  std::vector<Material> materials;
  GeoPosition origin = kDefaultSceneOrigin;  // of the ENU frame

  bool IsGround(std::size_t face) const { return object_of_face[face] == kGroundObject; }
  // The model without ground. Unused vertices are dropped; faces keep their order.
  GroundTruth Truth() const;
};

// Throws Error when the arrays of `scene` do not fit each other (sizes, indices, non-finite
// values).
void CheckScene(const TexturedScene& scene, const std::string& where);

// Scenes made by procedure; same arguments, same scene on every machine.
//   "church": 21 m long, 20 m high, on 80 x 80 m of textured ground; tower in the west, porch in
//   the
//             south, eaves that overhang 0.6 m, windows recessed by 0.3 m.
//   "gate":   Asian gate 15 m high with columns and brackets under a wide two-tier roof.
//   "boxes":  cardboard buildings of 0.5 … 1.6 m in a room of 8 x 8 m, open above.
// Faces that cannot be seen from outside (the inside of joints) are left out, so that the truth
// holds only what a photo can show. `texel_scale` > 1 makes coarser, quicker textures (for tests);
// 1 is 1.4 cm a texel on the church. Throws UsageError for an unknown name or a scale outside
// [0.5, 16].
TexturedScene MakeScene(const std::string& name, std::uint64_t seed, double texel_scale = 1.0);

struct LoadSceneOptions {
  bool add_ground = true;      // a textured ground plane at the model's lowest z
  double ground_margin_m = 0;  // how far it reaches past the model; 0: 2.5 times the model's extent
  GeoPosition origin = kDefaultSceneOrigin;
  std::uint64_t seed = 1;  // of the ground's texture
};

// Reads OBJ, glTF, COLLADA or whatever else assimp knows. COLLADA's unit and up axis are obeyed,
// glTF is y up in metres by its standard; OBJ and the others are taken as metres, z up. A texture
// that is missing or cannot be read becomes a flat colour, with a warning to `job`. Throws Error
// naming the file when it is missing, broken, or holds no triangle.
TexturedScene LoadScene(const std::filesystem::path& path, const LoadSceneOptions& options,
                        const JobControl& job);

// Writes `<name>.obj`, `<name>.mtl` and one PNG a texture into `folder` (created). Each object is a
// group `object_<id>`; LoadScene gives the same triangles back, with all faces as one object.
void WriteScene(const TexturedScene& scene, const std::filesystem::path& folder,
                const std::string& name);

}  // namespace colmap_ext
