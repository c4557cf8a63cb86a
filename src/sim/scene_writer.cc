#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <vector>

#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

std::string TextureName(const std::string& name, const Material& material) {
  return name + "_" + material.name + ".png";
}

void WriteTexture(const cv::Mat& bgr, const std::filesystem::path& path) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", bgr, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3})) {
    throw Error(path.string() + ": the texture cannot be encoded as PNG");
  }
  WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

std::string MaterialText(const TexturedScene& scene, const std::string& name) {
  std::ostringstream text;
  for (const Material& material : scene.materials) {
    text << "newmtl " << material.name << "\nKa 0 0 0\nKs 0 0 0\nillum 1\n";
    if (material.texture_bgr.empty()) {
      const Eigen::Vector3f rgb = material.flat_bgr.reverse() / 255.0F;
      text << "Kd " << rgb.x() << ' ' << rgb.y() << ' ' << rgb.z() << "\n\n";
    } else {
      text << "Kd 1 1 1\nmap_Kd " << TextureName(name, material) << "\n\n";
    }
  }
  return text.str();
}

void WriteGeometry(const TexturedScene& scene, const std::string& name, std::ostream& out) {
  out.precision(9);
  out << "# metres, x east, y north, z up\nmtllib " << name << ".mtl\n";
  for (const auto& v : scene.mesh.vertices) {
    out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  }
  for (const auto& n : scene.vertex_normals) {
    out << "vn " << n.x() << ' ' << n.y() << ' ' << n.z() << '\n';
  }
  for (const auto& corners : scene.corner_uv) {
    for (const auto& uv : corners) out << "vt " << uv.x() << ' ' << uv.y() << '\n';
  }
  int material = -1, object = -1;
  for (std::size_t i = 0; i < scene.mesh.faces.size(); ++i) {
    if (scene.object_of_face[i] != object) {
      object = scene.object_of_face[i];
      out << "g object_" << object << '\n';
    }
    if (scene.material_of_face[i] != material) {
      material = scene.material_of_face[i];
      out << "usemtl " << scene.materials[static_cast<std::size_t>(material)].name << '\n';
    }
    out << 'f';
    for (int k = 0; k < 3; ++k) {
      const int v = scene.mesh.faces[i][k] + 1;  // OBJ counts from 1
      out << ' ' << v << '/' << 3 * i + static_cast<std::size_t>(k) + 1 << '/' << v;
    }
    out << '\n';
  }
}

}  // namespace

void WriteScene(const TexturedScene& scene, const std::filesystem::path& folder,
                const std::string& name) {
  CheckScene(scene, name);
  RequireWritableFolder(folder, "folder for the scene");
  for (const Material& material : scene.materials) {
    if (material.texture_bgr.empty()) continue;
    WriteTexture(material.texture_bgr, folder / TextureName(name, material));
  }
  WriteFileAtomically(folder / (name + ".mtl"), MaterialText(scene, name));
  WriteFileAtomically(folder / (name + ".obj"),
                      [&](std::ostream& out) { WriteGeometry(scene, name, out); });
}

}  // namespace colmap_ext
