#include "sim/polygon_mesher.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <list>
#include <map>

namespace colmap_ext {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Tds = CGAL::Triangulation_data_structure_2<CGAL::Delaunay_mesh_vertex_base_2<Kernel>,
                                                 CGAL::Delaunay_mesh_face_base_2<Kernel>>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Tds>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Cdt>;

void InsertOutline(const std::vector<Eigen::Vector2d>& outline, Cdt* cdt) {
  std::vector<Cdt::Vertex_handle> handles;
  for (const auto& p : outline) handles.push_back(cdt->insert({p.x(), p.y()}));
  for (std::size_t i = 0; i < handles.size(); ++i) {
    cdt->insert_constraint(handles[i], handles[(i + 1) % handles.size()]);
  }
}

// A point inside a simple polygon: the centroid of an ear of its own triangulation.
Cdt::Point InnerPoint(const std::vector<Eigen::Vector2d>& outline) {
  Cdt cdt;
  InsertOutline(outline, &cdt);
  CGAL::refine_Delaunay_mesh_2(cdt, Criteria(0, 0));
  for (auto face = cdt.finite_faces_begin(); face != cdt.finite_faces_end(); ++face) {
    if (face->is_in_domain()) {
      return CGAL::centroid(face->vertex(0)->point(), face->vertex(1)->point(),
                            face->vertex(2)->point());
    }
  }
  return {outline.front().x(), outline.front().y()};
}

}  // namespace

PlanarMesh MeshPolygon(const std::vector<Eigen::Vector2d>& outer,
                       const std::vector<std::vector<Eigen::Vector2d>>& holes, double max_edge_m) {
  Cdt cdt;
  InsertOutline(outer, &cdt);
  std::list<Cdt::Point> seeds;
  for (const auto& hole : holes) {
    InsertOutline(hole, &cdt);
    seeds.push_back(InnerPoint(hole));
  }
  // 0.125: no angle below 20.7 degrees, for which the algorithm is known to end.
  CGAL::refine_Delaunay_mesh_2(cdt, seeds.begin(), seeds.end(), Criteria(0.125, max_edge_m));

  PlanarMesh mesh;
  std::map<Cdt::Vertex_handle, int> index_of;
  for (auto v = cdt.finite_vertices_begin(); v != cdt.finite_vertices_end(); ++v) {
    index_of[v] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.emplace_back(v->point().x(), v->point().y());
    mesh.on_border.push_back(cdt.are_there_incident_constraints(v));
  }
  for (auto face = cdt.finite_faces_begin(); face != cdt.finite_faces_end(); ++face) {
    if (!face->is_in_domain()) continue;
    mesh.faces.emplace_back(index_of[face->vertex(0)], index_of[face->vertex(1)],
                            index_of[face->vertex(2)]);
  }
  return mesh;
}

}  // namespace colmap_ext
