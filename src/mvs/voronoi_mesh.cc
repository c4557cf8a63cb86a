#include "mvs/voronoi_mesh.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "colmap_ext/util/error.h"
#include "mvs/polygon_triangulation.h"

namespace colmap_ext {
namespace {

constexpr double kMinTriangleArea = 0.05;  // px²

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Triangulation_face_base_with_info_2<int, Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_2<Kernel,
                                   CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>>;

// Sites and their mirror images at the four borders: the bisectors between a site and its images
// are the borders, so the cells of the sites come out clipped to the image, corners included.
std::vector<std::pair<Kernel::Point_2, int>> WithMirrorImages(
    const std::vector<Eigen::Vector2d>& sites, int width, int height, double band) {
  std::vector<std::pair<Kernel::Point_2, int>> points;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    const double x = sites[s].x();
    const double y = sites[s].y();
    points.emplace_back(Kernel::Point_2(x, y), static_cast<int>(s));
    if (x < band) points.emplace_back(Kernel::Point_2(-x, y), -1);
    if (y < band) points.emplace_back(Kernel::Point_2(x, -y), -1);
    if (width - x < band) points.emplace_back(Kernel::Point_2(2.0 * width - x, y), -1);
    if (height - y < band) points.emplace_back(Kernel::Point_2(x, 2.0 * height - y), -1);
  }
  return points;
}

Eigen::Vector2d Circumcenter(const Delaunay::Face_handle& face) {
  const auto corner = [&](int k) {
    const Kernel::Point_2& p = face->vertex(k)->point();
    return Eigen::Vector2d(p.x(), p.y());
  };
  const Eigen::Vector2d a = corner(0);
  const Eigen::Vector2d b = corner(1) - a;
  const Eigen::Vector2d c = corner(2) - a;
  const double d = 2 * (b.x() * c.y() - b.y() * c.x());
  const double bb = b.squaredNorm();
  const double cc = c.squaredNorm();
  return a + Eigen::Vector2d(c.y() * bb - b.y() * cc, b.x() * cc - c.x() * bb) / d;
}

// Polygons whose corners are Voronoi vertices, with vertices that have been merged.
class CellComplex {
 public:
  CellComplex(int width, int height) : width_(width), height_(height) {}

  int AddVertex(Eigen::Vector2d p) {
    p.x() = Snap(p.x(), width_);
    p.y() = Snap(p.y(), height_);
    const int id = static_cast<int>(vertices_.size());
    vertices_.push_back(p);
    parent_.push_back(id);
    members_.push_back(1);
    return id;
  }

  void AddPolygon(std::vector<int> corners) { polygons_.push_back(std::move(corners)); }

  int Find(int v) {
    while (Parent(v) != v) {
      Parent(v) = Parent(Parent(v));
      v = Parent(v);
    }
    return v;
  }

  const Eigen::Vector2d& Position(int v) { return vertices_[static_cast<std::size_t>(Find(v))]; }

  // The mean of both, but a border stays the border and a corner the corner.
  void Merge(int a, int b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return;
    if (a > b) std::swap(a, b);
    const Eigen::Vector2d p = vertices_[static_cast<std::size_t>(a)];
    const Eigen::Vector2d q = vertices_[static_cast<std::size_t>(b)];
    const double np = members_[static_cast<std::size_t>(a)];
    const double nq = members_[static_cast<std::size_t>(b)];
    Eigen::Vector2d& merged = vertices_[static_cast<std::size_t>(a)];
    merged.x() = MergeCoordinate(p.x(), np, q.x(), nq, width_);
    merged.y() = MergeCoordinate(p.y(), np, q.y(), nq, height_);
    members_[static_cast<std::size_t>(a)] += members_[static_cast<std::size_t>(b)];
    Parent(b) = a;
  }

  // A vertex that was drawn to a corner by two borders and the corner's own become one.
  void MergeCorners() {
    std::map<std::pair<double, double>, int> at_corner;
    for (int v = 0; v < static_cast<int>(vertices_.size()); ++v) {
      if (Find(v) != v) continue;
      const Eigen::Vector2d& p = vertices_[static_cast<std::size_t>(v)];
      if (!IsBorder(p.x(), width_) || !IsBorder(p.y(), height_)) continue;
      const auto [entry, is_new] = at_corner.emplace(std::make_pair(p.x(), p.y()), v);
      if (!is_new) Merge(entry->second, v);
    }
  }

  // Splits every polygon into triangles. Polygons that allow no good triangles lose their shortest
  // edge, until all do.
  ImageMesh Triangulate() {
    for (std::size_t attempt = 0; attempt <= vertices_.size(); ++attempt) {
      ImageMesh mesh;
      if (TryTriangulate(&mesh)) return mesh;
      MergeCorners();
    }
    throw Error("superpixels: the cells of the photo cannot be split into triangles");
  }

 private:
  static bool IsBorder(double value, double size) { return value == 0.0 || value == size; }
  static double Snap(double value, double size) {
    constexpr double kTolerance = 1e-4;
    if (value < kTolerance) return 0.0;
    if (value > size - kTolerance) return size;
    return value;
  }
  static double MergeCoordinate(double p, double np, double q, double nq, double size) {
    if (IsBorder(p, size)) return p;
    if (IsBorder(q, size)) return q;
    return (np * p + nq * q) / (np + nq);
  }
  int& Parent(int v) { return parent_[static_cast<std::size_t>(v)]; }

  // Corners of a polygon after merging, each once. A corner that comes back cuts off a loop of its
  // own, which is returned as another polygon.
  std::vector<std::vector<int>> Loops(const std::vector<int>& polygon) {
    std::vector<std::vector<int>> loops;
    std::vector<int> open;
    for (const int corner : polygon) {
      const int v = Find(corner);
      const auto seen = std::find(open.begin(), open.end(), v);
      if (seen != open.end()) {
        if (open.end() - seen >= 3) loops.emplace_back(seen, open.end());
        open.erase(seen, open.end());
      }
      open.push_back(v);
    }
    if (open.size() >= 3) loops.push_back(open);
    return loops;
  }

  void MergeShortestEdge(const std::vector<int>& loop) {
    std::size_t shortest = 0;
    double length = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const double l = (Position(loop[i]) - Position(loop[(i + 1) % loop.size()])).norm();
      if (l < length) {
        length = l;
        shortest = i;
      }
    }
    Merge(loop[shortest], loop[(shortest + 1) % loop.size()]);
  }

  bool TryTriangulate(ImageMesh* mesh) {
    bool complete = true;
    std::vector<int> index(vertices_.size(), -1);
    for (const std::vector<int>& polygon : polygons_) {
      bool is_new_superpixel = true;
      for (const std::vector<int>& loop : Loops(polygon)) {
        std::vector<Eigen::Vector2d> corners;
        for (const int v : loop) corners.push_back(vertices_[static_cast<std::size_t>(v)]);
        const PolygonTriangles triangles = TriangulatePolygon(corners, kMinTriangleArea);
        if (triangles.empty()) {
          complete = false;
          MergeShortestEdge(loop);
          break;  // this polygon's other loops may have changed
        }
        if (is_new_superpixel) ++mesh->num_superpixels;
        is_new_superpixel = false;
        for (const Eigen::Vector3i& triangle : triangles) {
          mesh->triangles.push_back(IndexCorners(triangle, loop, &index, mesh));
          mesh->superpixel.push_back(mesh->num_superpixels - 1);
        }
      }
    }
    return complete;
  }

  Eigen::Vector3i IndexCorners(const Eigen::Vector3i& triangle, const std::vector<int>& loop,
                               std::vector<int>* index, ImageMesh* mesh) const {
    Eigen::Vector3i corners;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(loop[static_cast<std::size_t>(triangle[k])]);
      int& i = (*index)[v];
      if (i < 0) {
        i = static_cast<int>(mesh->vertices_px.size());
        mesh->vertices_px.push_back(vertices_[v]);
      }
      corners[k] = i;
    }
    return corners;
  }

  double width_;
  double height_;
  std::vector<Eigen::Vector2d> vertices_;
  std::vector<int> parent_;
  std::vector<int> members_;
  std::vector<std::vector<int>> polygons_;
};

// The cells of the sites; faces get the id of their vertex of the complex in info(), others -1.
CellComplex MakeCells(Delaunay* delaunay, std::size_t num_sites, int width, int height) {
  CellComplex cells(width, height);
  for (const auto& face : delaunay->finite_face_handles()) {
    bool touches_site = false;
    for (int k = 0; k < 3; ++k) touches_site |= face->vertex(k)->info() >= 0;
    face->info() = touches_site ? cells.AddVertex(Circumcenter(face)) : -1;
  }
  std::vector<Delaunay::Vertex_handle> vertex_of_site(num_sites);
  for (const auto& vertex : delaunay->finite_vertex_handles()) {
    if (vertex->info() >= 0) vertex_of_site[static_cast<std::size_t>(vertex->info())] = vertex;
  }
  for (const Delaunay::Vertex_handle& vertex : vertex_of_site) {
    std::vector<int> corners;
    auto face = delaunay->incident_faces(vertex);
    const auto first = face;
    do {
      corners.push_back(face->info());
    } while (++face != first);
    cells.AddPolygon(std::move(corners));
  }
  return cells;
}

}  // namespace

ImageMesh BuildVoronoiMesh(const std::vector<Eigen::Vector2d>& sites_px, int width, int height,
                           double cover_radius_px, double merge_px) {
  const auto points = WithMirrorImages(sites_px, width, height, cover_radius_px + 1.0);
  Delaunay delaunay(points.begin(), points.end());
  merge_px = std::min(merge_px, 0.25 * std::min(width, height));  // a tiny image keeps its corners
  CellComplex cells = MakeCells(&delaunay, sites_px.size(), width, height);
  for (const auto& face : delaunay.finite_face_handles()) {
    for (int k = 0; k < 3; ++k) {
      const auto other = face->neighbor(k);
      if (delaunay.is_infinite(other) || face->info() < 0 || other->info() <= face->info())
        continue;
      if ((cells.Position(face->info()) - cells.Position(other->info())).norm() < merge_px) {
        cells.Merge(face->info(), other->info());
      }
    }
  }
  cells.MergeCorners();
  ImageMesh mesh = cells.Triangulate();
  ConnectTriangles(&mesh);
  return mesh;
}

void ConnectTriangles(ImageMesh* mesh) {
  struct Side {
    int low, high;    // vertices
    int triangle, k;  // opposite corner
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh->triangles.size());
  for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh->triangles[t][(k + 1) % 3];
      const int b = mesh->triangles[t][(k + 2) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  mesh->neighbors.assign(mesh->triangles.size(), Eigen::Vector3i::Constant(-1));
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side& a = sides[i];
    const Side& b = sides[i + 1];
    if (a.low != b.low || a.high != b.high) continue;
    mesh->neighbors[static_cast<std::size_t>(a.triangle)][a.k] = b.triangle;
    mesh->neighbors[static_cast<std::size_t>(b.triangle)][b.k] = a.triangle;
  }
}

}  // namespace colmap_ext
