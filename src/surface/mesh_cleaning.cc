#include "surface/mesh_cleaning.h"

#include <algorithm>
#include <numeric>

namespace colmap_ext {
namespace {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  void Join(std::size_t a, std::size_t b) { parent_[Find(a)] = Find(b); }

 private:
  std::vector<std::size_t> parent_;
};

std::size_t Corner(const Eigen::Vector3i& face, int k) { return static_cast<std::size_t>(face[k]); }

}  // namespace

Surface KeepFaces(const Surface& surface, const std::vector<bool>& keep) {
  std::vector<int> new_index(surface.mesh.vertices.size(), -1);
  for (std::size_t f = 0; f < surface.mesh.faces.size(); ++f) {
    if (!keep[f]) continue;
    for (int k = 0; k < 3; ++k) new_index[Corner(surface.mesh.faces[f], k)] = 0;
  }
  Surface kept;
  for (std::size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] < 0) continue;
    new_index[v] = static_cast<int>(kept.mesh.vertices.size());
    kept.mesh.vertices.push_back(surface.mesh.vertices[v]);
    kept.sample_spacing_m.push_back(surface.sample_spacing_m[v]);
    kept.scatter_m.push_back(surface.scatter_m[v]);
    kept.color.push_back(surface.color[v]);
  }
  for (std::size_t f = 0; f < surface.mesh.faces.size(); ++f) {
    if (!keep[f]) continue;
    const Eigen::Vector3i& face = surface.mesh.faces[f];
    kept.mesh.faces.emplace_back(new_index[Corner(face, 0)], new_index[Corner(face, 1)],
                                 new_index[Corner(face, 2)]);
  }
  return kept;
}

std::vector<bool> FacesOfLargePieces(const TriangleMesh& mesh, double min_area_m2) {
  DisjointSets pieces(mesh.vertices.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    pieces.Join(Corner(face, 0), Corner(face, 1));
    pieces.Join(Corner(face, 0), Corner(face, 2));
  }
  std::vector<double> area(mesh.vertices.size(), 0.0);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    area[pieces.Find(Corner(mesh.faces[f], 0))] += FaceArea(mesh, f);
  }
  const double largest = area.empty() ? 0.0 : *std::max_element(area.begin(), area.end());
  const double threshold = std::min(min_area_m2, largest);
  std::vector<bool> keep(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    keep[f] = area[pieces.Find(Corner(mesh.faces[f], 0))] >= threshold;
  }
  return keep;
}

double TotalArea(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) area += FaceArea(mesh, f);
  return area;
}

}  // namespace colmap_ext
