#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "sim/face_visibility.h"
#include "sim/painters.h"
#include "sim/scene_builder.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// assimp turns COLLADA into y up by its up axis, and glTF is y up; other formats come as they are,
// and are taken as z up.
Eigen::Affine3d WorldFromModel(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  Eigen::Affine3d world_from_model = Eigen::Affine3d::Identity();
  if (extension == ".dae" || extension == ".gltf" || extension == ".glb") {
    world_from_model.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  }
  return world_from_model;
}

Eigen::Affine3d ToEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return Eigen::Affine3d(matrix);
}

cv::Mat ReadEmbeddedTexture(const aiTexture& texture) {
  if (texture.mHeight == 0) {  // a compressed picture of mWidth bytes
    const auto* bytes = reinterpret_cast<const unsigned char*>(texture.pcData);
    return cv::imdecode(std::vector<unsigned char>(bytes, bytes + texture.mWidth),
                        cv::IMREAD_COLOR);
  }
  cv::Mat bgr(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC3);
  for (int i = 0; i < bgr.rows * bgr.cols; ++i) {
    const aiTexel& texel = texture.pcData[i];
    bgr.at<cv::Vec3b>(i) = {texel.b, texel.g, texel.r};
  }
  return bgr;
}

// The texture's file: beside the model as named, or by its name alone (models move, absolute paths
// do not follow).
fs::path FindTexture(const fs::path& model, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  if (name.starts_with("file://")) name.erase(0, 7);
  const fs::path folder = model.parent_path();
  for (const fs::path& candidate : {folder / name, folder / fs::path(name).filename()}) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) return candidate;
  }
  return {};
}

class Loader {
 public:
  Loader(const fs::path& path, const JobControl& job) : path_(path), job_(job) {}

  TexturedScene Load() {
    RequireFile(path_, "scene");
    Assimp::Importer importer;
    const aiScene* model = importer.ReadFile(
        path_.string(), aiProcess_Triangulate | aiProcess_GenSmoothNormals |
                            aiProcess_JoinIdenticalVertices | aiProcess_SortByPType);
    if (model == nullptr || model->mRootNode == nullptr ||
        (model->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0) {
      std::string reason = importer.GetErrorString();
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      throw Error(path_.string() + ": cannot be read as a 3D model (" + reason +
                  "); check the file, or convert it to OBJ or glTF");
    }
    for (unsigned i = 0; i < model->mNumMaterials; ++i) {
      scene_.materials.push_back(ConvertMaterial(*model, *model->mMaterials[i], i));
    }
    if (scene_.materials.empty()) scene_.materials.push_back({"default", {}, {160, 160, 160}});
    AddNode(*model, *model->mRootNode, WorldFromModel(path_));
    CheckScene(scene_, path_.string());
    return std::move(scene_);
  }

 private:
  Material ConvertMaterial(const aiScene& model, const aiMaterial& source, unsigned index) {
    Material material;
    material.name = "material_" + std::to_string(index);
    aiColor4D color(0.6F, 0.6F, 0.6F, 1);
    if (source.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS) {
      const auto byte = [](float v) { return std::clamp(v, 0.0F, 1.0F) * 255.0F; };
      material.flat_bgr = {byte(color.b), byte(color.g), byte(color.r)};
    }
    aiString name;
    if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &name) != aiReturn_SUCCESS &&
        source.GetTexture(aiTextureType_DIFFUSE, 0, &name) != aiReturn_SUCCESS) {
      return material;
    }
    if (const aiTexture* embedded = model.GetEmbeddedTexture(name.C_Str())) {
      material.texture_bgr = ReadEmbeddedTexture(*embedded);
    } else if (const fs::path file = FindTexture(path_, name.C_Str()); !file.empty()) {
      material.texture_bgr = cv::imread(file.string(), cv::IMREAD_COLOR);
    }
    if (material.texture_bgr.empty()) {
      material.flat_bgr = {150, 160, 165};
      job_.Warn(path_.string() + ": texture '" + name.C_Str() +
                "' is missing or cannot be read; a flat colour takes its place");
    }
    return material;
  }

  void AddNode(const aiScene& model, const aiNode& node, const Eigen::Affine3d& world_from_parent) {
    const Eigen::Affine3d world_from_node = world_from_parent * ToEigen(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      AddMesh(*model.mMeshes[node.mMeshes[i]], world_from_node);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
      AddNode(model, *node.mChildren[i], world_from_node);
    }
  }

  void AddMesh(const aiMesh& mesh, const Eigen::Affine3d& world_from_mesh) {
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) return;
    const auto first = static_cast<int>(scene_.mesh.vertices.size());
    const Eigen::Matrix3d linear = world_from_mesh.linear();
    const bool mirrored = linear.determinant() < 0;
    const Eigen::Matrix3d normal_matrix = linear.inverse().transpose();
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& p = mesh.mVertices[i];
      scene_.mesh.vertices.push_back(world_from_mesh * Eigen::Vector3d(p.x, p.y, p.z));
      Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
      if (mesh.HasNormals()) {
        const aiVector3D& n = mesh.mNormals[i];
        const Eigen::Vector3d turned = normal_matrix * Eigen::Vector3d(n.x, n.y, n.z);
        if (turned.allFinite() && turned.norm() > 1e-12) normal = turned.normalized();
      }
      scene_.vertex_normals.push_back(normal.cast<float>());
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      if (mesh.mFaces[i].mNumIndices == 3) AddFace(mesh, mesh.mFaces[i], first, mirrored);
    }
  }

  void AddFace(const aiMesh& mesh, const aiFace& source, int first, bool mirrored) {
    Eigen::Vector3i face;
    std::array<Eigen::Vector2f, 3> uv;
    for (int k = 0; k < 3; ++k) {
      const unsigned index = source.mIndices[mirrored ? 2 - k : k];
      face[k] = first + static_cast<int>(index);
      uv[static_cast<std::size_t>(k)] = Eigen::Vector2f::Zero();
      if (!mesh.HasTextureCoords(0)) continue;
      const aiVector3D& t = mesh.mTextureCoords[0][index];
      uv[static_cast<std::size_t>(k)] = {t.x, t.y};
    }
    scene_.mesh.faces.push_back(face);
    scene_.corner_uv.push_back(uv);
    scene_.material_of_face.push_back(static_cast<int>(mesh.mMaterialIndex));
    scene_.object_of_face.push_back(1);
  }

  const fs::path& path_;
  const JobControl& job_;
  TexturedScene scene_;
};

// Appends the faces of `addition`.
void Append(TexturedScene addition, TexturedScene* scene) {
  const auto vertices = static_cast<int>(scene->mesh.vertices.size());
  const auto materials = static_cast<int>(scene->materials.size());
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (auto& face : addition.mesh.faces) face.array() += vertices;
  for (auto& material : addition.material_of_face) material += materials;
  append(scene->mesh.vertices, addition.mesh.vertices);
  append(scene->mesh.faces, addition.mesh.faces);
  append(scene->vertex_normals, addition.vertex_normals);
  append(scene->corner_uv, addition.corner_uv);
  append(scene->material_of_face, addition.material_of_face);
  append(scene->object_of_face, addition.object_of_face);
  append(scene->materials, addition.materials);
}

// Meadow a little below the model's lowest point, so that a floor at that height stays visible.
// Detail grows with the model; a coarse ring takes it to the horizon.
TexturedScene MakeGroundPlane(const BoundingBox& model, const LoadSceneOptions& options) {
  const double extent = std::max(model.sizes().x(), model.sizes().y());
  const double margin = options.ground_margin_m > 0 ? options.ground_margin_m : 2.5 * extent;
  const double half = extent / 2 + margin;
  const double scale = std::max(1e-3, extent / 20);  // 1 for a model of 20 m
  SceneBuilder builder(options.seed, 1.0);
  const Painter meadow = Meadow(static_cast<std::uint32_t>(options.seed) + 60U);
  // The painter's patterns are in metres of a scene of ordinary size; small models get small grass.
  const auto scaled = [meadow, scale](const SurfacePoint& p) {
    SurfacePoint point = p;
    if (scale < 0.5) point.world /= static_cast<float>(2 * scale);
    return meadow(point);
  };
  const Eigen::Vector3d center = model.center();
  const PlaneFrame frame{{center.x(), center.y(), model.min().z() - 2e-3 * scale},
                         Eigen::Vector3d::UnitX(),
                         Eigen::Vector3d::UnitY()};
  const auto square = [](double h) { return RectanglePolygon(-h, -h, h, h); };
  builder.AddRectangle(builder.AddMaterial("added_ground", 2 * half / 2400, scaled),
                       frame.Moved(-half, -half), 2 * half, 2 * half, half / 60);
  builder.AddPolygon(builder.AddMaterial("added_ground_far", 10 * half / 1400, scaled), frame,
                     square(5 * half), {square(half)}, half);
  return builder.Finish(options.origin);
}

}  // namespace

TexturedScene LoadScene(const std::filesystem::path& path, const LoadSceneOptions& options,
                        const JobControl& job) {
  TexturedScene scene = Loader(path, job).Load();
  scene.origin = options.origin;
  if (options.add_ground) {
    Append(MakeGroundPlane(BoundsOf(scene.mesh), options), &scene);
  }
  return scene;
}

}  // namespace colmap_ext
