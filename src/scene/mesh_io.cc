#include "colmap_ext/scene/mesh_io.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/error.h"
#include "scene/ply_columns.h"

namespace colmap_ext {
namespace {

// Both names are in use: vertex_indices by most programs, vertex_index by CGAL and some scanners.
const PlyList* FindCorners(const PlyElement& faces) {
  const PlyList* list = faces.FindList("vertex_indices");
  return list != nullptr ? list : faces.FindList("vertex_index");
}

std::vector<Eigen::Vector3i> ReadFaces(const PlyData& data, std::size_t num_vertices,
                                       const std::filesystem::path& path) {
  std::vector<Eigen::Vector3i> triangles;
  const PlyElement* faces = data.FindElement("face");
  if (faces == nullptr || faces->count == 0) return triangles;
  const PlyList* corners = FindCorners(*faces);
  if (corners == nullptr) throw Error(path.string() + ": the faces have no list vertex_indices");
  const ColumnReader reader(data, "face", path);
  triangles.reserve(faces->count);
  for (std::size_t face = 0; face < faces->count; ++face) {
    const std::size_t begin = corners->starts[face];
    const std::size_t end = corners->starts[face + 1];
    if (end - begin < 3) reader.Fail(face, "fewer than three corners");
    for (std::size_t i = begin; i < end; ++i) {
      const double corner = corners->items[i];
      if (!(corner >= 0) || corner >= static_cast<double>(num_vertices) ||
          corner != std::floor(corner)) {
        reader.Fail(face,
                    "a corner is not one of the " + std::to_string(num_vertices) + " vertices");
      }
    }
    const auto corner_at = [&](std::size_t i) { return static_cast<int>(corners->items[i]); };
    for (std::size_t i = begin + 2; i < end; ++i) {
      triangles.emplace_back(corner_at(begin), corner_at(i - 1), corner_at(i));
    }
  }
  return triangles;
}

ColoredMesh MeshFromPly(const PlyData& data, const std::filesystem::path& path) {
  const ColumnReader vertices(data, "vertex", path);
  ColoredMesh result;
  result.mesh.vertices = vertices.Vectors(kPositionColumns);
  result.mesh.faces = ReadFaces(data, result.mesh.vertices.size(), path);
  if (vertices.HasAll(kColorColumns)) {
    for (const Rgb8& color : vertices.Colors()) result.color.push_back(ColorFrom8Bit(color));
  }
  return result;
}

void CheckWritable(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& color,
                   const std::string& path) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      throw Error(path + ": vertex " + std::to_string(i) + " of the mesh is not finite");
    }
  }
  const int num_vertices = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (mesh.faces[i].minCoeff() < 0 || mesh.faces[i].maxCoeff() >= num_vertices) {
      throw Error(path + ": face " + std::to_string(i) +
                  " of the mesh has a corner that is no vertex");
    }
  }
  if (!color.empty() && color.size() != mesh.vertices.size()) {
    throw Error(path + ": " + std::to_string(color.size()) + " colours for " +
                std::to_string(mesh.vertices.size()) + " vertices");
  }
}

PlyElement VertexElement(const TriangleMesh& mesh) {
  PlyElement vertices;
  vertices.name = "vertex";
  vertices.count = mesh.vertices.size();
  AddVectors(kPositionColumns, mesh.vertices, &vertices);
  return vertices;
}

void AddVertexColors(const std::vector<Eigen::Vector3d>& color, PlyElement* vertices) {
  if (color.empty()) return;
  std::vector<Rgb8> quantized(color.size());
  std::transform(color.begin(), color.end(), quantized.begin(), QuantizedColor);
  AddColors(quantized, vertices);
}

PlyElement FaceElement(const TriangleMesh& mesh) {
  PlyElement faces;
  faces.name = "face";
  faces.count = mesh.faces.size();
  PlyList corners;
  corners.name = "vertex_indices";
  corners.starts.reserve(faces.count + 1);
  corners.items.reserve(3 * faces.count);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) corners.items.push_back(face[k]);
    corners.starts.push_back(corners.items.size());
  }
  faces.lists.push_back(std::move(corners));
  return faces;
}

void CheckSignal(const std::string& name, const std::vector<double>& values,
                 const TriangleMesh& mesh, const std::filesystem::path& path) {
  if (values.size() != mesh.vertices.size()) {
    throw Error(path.string() + ": " + std::to_string(values.size()) + " values of " + name +
                " for " + std::to_string(mesh.vertices.size()) + " vertices");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw Error(path.string() + ": " + name + " of vertex " + std::to_string(i) + " is not finite");
  }
}

}  // namespace

TriangleMesh ReadMesh(const std::filesystem::path& path) { return ReadColoredMesh(path).mesh; }

ColoredMesh ReadColoredMesh(const std::filesystem::path& path) {
  return MeshFromPly(ReadPly(path), path);
}

void WriteMesh(const TriangleMesh& mesh, const std::filesystem::path& path) {
  WriteMesh(mesh, {}, path);
}

void WriteMesh(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& color,
               const std::filesystem::path& path) {
  CheckWritable(mesh, color, path.string());
  PlyElement vertices = VertexElement(mesh);
  AddVertexColors(color, &vertices);
  PlyData data;
  data.elements = {std::move(vertices), FaceElement(mesh)};
  WritePly(data, path);
}

Surface ReadSurface(const std::filesystem::path& path) {
  const PlyData data = ReadPly(path);
  ColoredMesh colored = MeshFromPly(data, path);
  Surface surface;
  surface.mesh = std::move(colored.mesh);
  surface.color = std::move(colored.color);
  const ColumnReader vertices(data, "vertex", path);
  surface.sample_spacing_m = vertices.Numbers("sample_spacing_m");
  if (vertices.Has("scatter_m")) surface.scatter_m = vertices.Numbers("scatter_m");
  return surface;
}

void WriteSurface(const Surface& surface, const std::filesystem::path& path) {
  CheckWritable(surface.mesh, surface.color, path.string());
  CheckSignal("sample_spacing_m", surface.sample_spacing_m, surface.mesh, path);
  const bool has_scatter = !surface.scatter_m.empty();
  if (has_scatter) CheckSignal("scatter_m", surface.scatter_m, surface.mesh, path);
  PlyElement vertices = VertexElement(surface.mesh);
  AddNumbers("sample_spacing_m", PlyType::kFloat64, surface.sample_spacing_m, &vertices);
  if (has_scatter) AddNumbers("scatter_m", PlyType::kFloat64, surface.scatter_m, &vertices);
  AddVertexColors(surface.color, &vertices);
  PlyData data;
  data.elements = {std::move(vertices), FaceElement(surface.mesh)};
  WritePly(data, path);
}

}  // namespace colmap_ext
