#include "colmap_ext/geom/mesh.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_map>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

Eigen::Vector3d ScaledNormal(const TriangleMesh& mesh, std::size_t face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(f[0])];
  const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(f[1])];
  const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(f[2])];
  return (b - a).cross(c - a);
}

// Same sequence on every platform, unlike std::uniform_real_distribution.
double NextUnit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

SurfaceSample SampleFace(const TriangleMesh& mesh, std::size_t face, std::mt19937_64& random) {
  const Eigen::Vector3i& f = mesh.faces[face];
  const double root = std::sqrt(NextUnit(random));
  const double second = NextUnit(random);
  SurfaceSample sample;
  sample.position = (1.0 - root) * mesh.vertices[static_cast<std::size_t>(f[0])] +
                    root * (1.0 - second) * mesh.vertices[static_cast<std::size_t>(f[1])] +
                    root * second * mesh.vertices[static_cast<std::size_t>(f[2])];
  sample.normal = FaceNormal(mesh, face);
  sample.face = static_cast<int>(face);
  return sample;
}

std::vector<SurfaceSample> SampleFaces(const TriangleMesh& mesh, std::size_t count,
                                       std::uint64_t seed, const std::vector<bool>& face_mask) {
  std::vector<double> accumulated;
  accumulated.reserve(mesh.faces.size());
  double total = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const bool is_used = face_mask.empty() || face_mask[face];
    total += is_used ? FaceArea(mesh, face) : 0.0;
    accumulated.push_back(total);
  }
  std::vector<SurfaceSample> samples;
  if (!(total > 0)) return samples;
  samples.reserve(count);
  std::mt19937_64 random(seed);
  std::size_t face = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Stratified: sample i lies in the i-th of `count` equal parts of the area.
    const double target =
        total * (static_cast<double>(i) + NextUnit(random)) / static_cast<double>(count);
    while (face + 1 < accumulated.size() && accumulated[face] <= target) ++face;
    samples.push_back(SampleFace(mesh, face, random));
  }
  return samples;
}

// Integer cell of a point in a grid of edge `cell`.
struct CellKey {
  std::int64_t x, y, z;
  bool operator==(const CellKey&) const = default;
};

struct CellHash {
  std::size_t operator()(const CellKey& key) const {
    return static_cast<std::size_t>(key.x * 73856093 ^ key.y * 19349663 ^ key.z * 83492791);
  }
};

// Remembers accepted points; answers whether one lies within the radius.
class PointGrid {
 public:
  explicit PointGrid(double radius) : radius_(radius) {}

  bool HasNeighbor(const Eigen::Vector3d& point) const {
    const CellKey center = KeyOf(point);
    for (std::int64_t x = center.x - 1; x <= center.x + 1; ++x) {
      for (std::int64_t y = center.y - 1; y <= center.y + 1; ++y) {
        for (std::int64_t z = center.z - 1; z <= center.z + 1; ++z) {
          if (CellHasNeighbor({x, y, z}, point)) return true;
        }
      }
    }
    return false;
  }

  void Insert(const Eigen::Vector3d& point) { cells_[KeyOf(point)].push_back(point); }

 private:
  CellKey KeyOf(const Eigen::Vector3d& point) const {
    const auto cell = [this](double value) {
      return static_cast<std::int64_t>(std::floor(value / radius_));
    };
    return {cell(point.x()), cell(point.y()), cell(point.z())};
  }

  bool CellHasNeighbor(const CellKey& key, const Eigen::Vector3d& point) const {
    const auto found = cells_.find(key);
    if (found == cells_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [&](const Eigen::Vector3d& p) {
      return (p - point).squaredNorm() < radius_ * radius_;
    });
  }

  double radius_;
  std::unordered_map<CellKey, std::vector<Eigen::Vector3d>, CellHash> cells_;
};

}  // namespace

BoundingBox BoundsOf(const TriangleMesh& mesh) {
  BoundingBox box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

Eigen::Vector3d FaceNormal(const TriangleMesh& mesh, std::size_t face) {
  const Eigen::Vector3d normal = ScaledNormal(mesh, face);
  const double length = normal.norm();
  return length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

double FaceArea(const TriangleMesh& mesh, std::size_t face) {
  return 0.5 * ScaledNormal(mesh, face).norm();
}

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Eigen::Vector3d scaled = ScaledNormal(mesh, face);
    for (int k = 0; k < 3; ++k) normals[static_cast<std::size_t>(mesh.faces[face][k])] += scaled;
  }
  for (Eigen::Vector3d& normal : normals) {
    if (normal.norm() > 0) normal.normalize();
  }
  return normals;
}

std::vector<SurfaceSample> SampleUniformly(const TriangleMesh& mesh, std::size_t count,
                                           std::uint64_t seed) {
  return SampleFaces(mesh, count, seed, {});
}

std::vector<SurfaceSample> SamplePoissonDisk(const TriangleMesh& mesh, double radius_m,
                                             std::uint64_t seed,
                                             const std::vector<bool>& face_mask) {
  if (!(radius_m > 0)) throw Error("Poisson-disk sampling needs a radius above 0 m");
  double area = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (face_mask.empty() || face_mask[face]) area += FaceArea(mesh, face);
  }
  // A dense uniform sampling, thinned in random order. A maximal packing of disks has about
  // 0.7 / radius² points an area; 20 candidates for each make gaps beyond 2 radii improbable.
  constexpr double kCandidatesPerDisk = 20.0;
  const double wanted = kCandidatesPerDisk * 0.7 * area / (radius_m * radius_m);
  constexpr double kMaxCandidates = 2e8;
  if (wanted > kMaxCandidates) throw Error("Poisson-disk sampling: the radius is too small");
  const std::vector<SurfaceSample> candidates =
      SampleFaces(mesh, static_cast<std::size_t>(std::ceil(wanted)), seed, face_mask);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(candidates.size());
  for (const SurfaceSample& candidate : candidates) positions.push_back(candidate.position);
  std::vector<SurfaceSample> samples;
  for (const std::size_t i : ThinPoints(positions, radius_m, seed ^ 0x9e3779b97f4a7c15ULL)) {
    samples.push_back(candidates[i]);
  }
  return samples;
}

std::vector<std::size_t> ThinPoints(const std::vector<Eigen::Vector3d>& points, double radius_m,
                                    std::uint64_t seed) {
  PointGrid grid(radius_m);
  std::vector<std::size_t> kept;
  for (const std::size_t i : RandomOrder(points.size(), seed)) {
    if (grid.HasNeighbor(points[i])) continue;
    grid.Insert(points[i]);
    kept.push_back(i);
  }
  return kept;
}

}  // namespace colmap_ext
