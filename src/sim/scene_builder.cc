#include "sim/scene_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/noise.h"
#include "sim/polygon_mesher.h"

namespace colmap_ext {

Polygon2d RectanglePolygon(double left, double bottom, double right, double top) {
  return {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
}

SceneBuilder::SceneBuilder(std::uint64_t seed, double texel_scale)
    : seed_(HashBits(static_cast<std::uint32_t>(seed) ^ static_cast<std::uint32_t>(seed >> 32))),
      texel_scale_(texel_scale) {}

int SceneBuilder::AddMaterial(const std::string& name, double texel_m, Painter painter) {
  materials_.push_back({name, texel_m * texel_scale_, std::move(painter)});
  return static_cast<int>(materials_.size()) - 1;
}

int SceneBuilder::AddChart(int material, const Eigen::Vector2d& size_m,
                           const Eigen::Vector2d& pattern_origin,
                           std::function<Eigen::Vector3d(const Eigen::Vector2d&)> local_at) {
  const Eigen::Isometry3d placement = placement_;
  charts_.push_back({material, size_m, pattern_origin,
                     [placement, local = std::move(local_at)](const Eigen::Vector2d& p) {
                       return Eigen::Vector3d(placement * local(p));
                     }});
  return static_cast<int>(charts_.size()) - 1;
}

int SceneBuilder::AddVertex(int chart, const Eigen::Vector3d& local,
                            const Eigen::Vector2d& chart_m) {
  vertices_.push_back({placement_ * local, chart, chart_m});
  return static_cast<int>(vertices_.size()) - 1;
}

void SceneBuilder::AddTriangle(int a, int b, int c) {
  faces_.emplace_back(a, b, c);
  object_of_face_.push_back(object_);
}

void SceneBuilder::Displace(int vertex, const Eigen::Vector3d& offset_in_world) {
  vertices_[static_cast<std::size_t>(vertex)].world += offset_in_world;
}

void SceneBuilder::AddPolygon(int material, const PlaneFrame& frame, const Polygon2d& outer,
                              const std::vector<Polygon2d>& holes, double max_edge_m,
                              double relief_m) {
  const PlanarMesh mesh = MeshPolygon(outer, holes, max_edge_m);
  Eigen::AlignedBox2d bounds;
  for (const auto& p : outer) bounds.extend(p);
  const PlaneFrame corner = frame.Moved(bounds.min().x(), bounds.min().y());
  // The pattern of a plane is tied to the world, so that it goes on from polygon to polygon.
  const Eigen::Vector2d pattern(corner.origin.dot(frame.u), corner.origin.dot(frame.v));
  const int chart = AddChart(material, bounds.sizes(), pattern,
                             [corner](const Eigen::Vector2d& p) { return corner.At(p); });
  std::vector<int> index(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d flat = frame.At(mesh.vertices[i]);
    double out = 0;
    if (relief_m > 0 && !mesh.on_border[i]) {
      const Eigen::Vector3f where = (flat * 2.3).cast<float>();
      out = relief_m * static_cast<double>(Noise(where, seed_ + 77U));
    }
    index[i] = AddVertex(chart, flat + out * frame.Normal(), mesh.vertices[i] - bounds.min());
  }
  const auto at = [&](int i) { return index[static_cast<std::size_t>(i)]; };
  for (const auto& face : mesh.faces) AddTriangle(at(face[0]), at(face[1]), at(face[2]));
}

void SceneBuilder::AddRectangle(int material, const PlaneFrame& frame, double a, double b,
                                double max_edge_m, double relief_m) {
  const Eigen::Vector2d pattern(frame.origin.dot(frame.u), frame.origin.dot(frame.v));
  const int nu = std::max(1, static_cast<int>(std::ceil(a / max_edge_m)));
  const int nv = std::max(1, static_cast<int>(std::ceil(b / max_edge_m)));
  const int chart = AddChart(material, {a, b}, pattern,
                             [frame](const Eigen::Vector2d& p) { return frame.At(p); });
  const int first = static_cast<int>(vertices_.size());
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const Eigen::Vector2d p(a * i / nu, b * j / nv);
      const bool border = i == 0 || j == 0 || i == nu || j == nv;
      const Eigen::Vector3f where = (frame.At(p) * 2.3).cast<float>();
      const double out =
          border || relief_m <= 0 ? 0 : relief_m * static_cast<double>(Noise(where, seed_ + 77U));
      AddVertex(chart, frame.At(p, out), p);
    }
  }
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      const int v = first + j * (nu + 1) + i;
      AddTriangle(v, v + 1, v + nu + 2);
      AddTriangle(v, v + nu + 2, v + nu + 1);
    }
  }
}

void SceneBuilder::AddGrid(int material, int nu, int nv, const Eigen::Vector2d& size_m,
                           const std::function<Eigen::Vector3d(double, double)>& local_at,
                           const std::function<Eigen::Vector2d(double, double)>& chart_at) {
  const Eigen::Vector3d origin = local_at(0, 0), along_u = local_at(1, 0), along_v = local_at(0, 1);
  // Painters only need the place roughly: bilinear is enough.
  const int chart = AddChart(material, size_m, Eigen::Vector2d::Zero(),
                             [=](const Eigen::Vector2d& p) -> Eigen::Vector3d {
                               return origin + (along_u - origin) * (p.x() / size_m.x()) +
                                      (along_v - origin) * (p.y() / size_m.y());
                             });
  const int first = static_cast<int>(vertices_.size());
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const double s = static_cast<double>(i) / nu, t = static_cast<double>(j) / nv;
      AddVertex(chart, local_at(s, t), chart_at(s, t));
    }
  }
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      const int v = first + j * (nu + 1) + i;
      AddTriangle(v, v + 1, v + nu + 2);
      AddTriangle(v, v + nu + 2, v + nu + 1);
    }
  }
}

// The side quad of a prism below the front edge from -> to. Axes are chosen so that the pattern's
// courses stay level on upright sides.
void SceneBuilder::AddStripQuad(int material, const PlaneFrame& front, const Eigen::Vector2d& from,
                                const Eigen::Vector2d& to, double depth_m, double max_edge_m) {
  const double length = (to - from).norm();
  if (length < 1e-6) return;
  const Eigen::Vector3d edge = (front.At(to) - front.At(from)) / length;
  const Eigen::Vector3d normal = front.Normal();
  if (edge.z() > 0.7) {
    AddRectangle(material, {front.At(from), -normal, edge}, depth_m, length, max_edge_m);
  } else if (edge.z() < -0.7) {
    AddRectangle(material, {front.At(to, -depth_m), normal, -edge}, depth_m, length, max_edge_m);
  } else {
    AddRectangle(material, {front.At(from, -depth_m), edge, normal}, length, depth_m, max_edge_m);
  }
}

void SceneBuilder::AddStrip(int material, const PlaneFrame& frame, const Polygon2d& line,
                            bool closed, double depth_m, double max_edge_m) {
  const std::size_t edges = closed ? line.size() : line.size() - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    AddStripQuad(material, frame, line[i], line[(i + 1) % line.size()], depth_m, max_edge_m);
  }
}

void SceneBuilder::AddPrism(int material, const PlaneFrame& frame, const Polygon2d& polygon,
                            double depth_m, double max_edge_m, bool with_back) {
  AddPolygon(material, frame, polygon, {}, max_edge_m);
  AddStrip(material, frame, polygon, true, depth_m, max_edge_m);
  if (!with_back) return;
  Polygon2d mirrored;
  for (auto p = polygon.rbegin(); p != polygon.rend(); ++p) mirrored.emplace_back(-p->x(), p->y());
  AddPolygon(material, {frame.At(0, 0, -depth_m), -frame.u, frame.v}, mirrored, {}, max_edge_m);
}

void SceneBuilder::AddBlock(int material, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                            double max_edge_m) {
  const Eigen::Vector3d size = high - low;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const auto side = [&](const PlaneFrame& frame, double a, double b) {
    AddRectangle(material, frame, a, b, max_edge_m);
  };
  side({low, x, z}, size.x(), size.z());
  side({{high.x(), low.y(), low.z()}, y, z}, size.y(), size.z());
  side({{high.x(), high.y(), low.z()}, -x, z}, size.x(), size.z());
  side({{low.x(), high.y(), low.z()}, -y, z}, size.y(), size.z());
  side({{low.x(), low.y(), high.z()}, x, y}, size.x(), size.y());
  side({{low.x(), high.y(), low.z()}, x, -y}, size.x(), size.y());
}

void SceneBuilder::AddBar(int material, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                          double width_m, double height_m, const Eigen::Vector3d& up) {
  const Eigen::Isometry3d before = placement_;
  const Eigen::Vector3d x = (to - from).normalized();
  const Eigen::Vector3d y = up.cross(x).normalized();
  Eigen::Isometry3d local_from_bar = Eigen::Isometry3d::Identity();
  local_from_bar.linear() << x, y, x.cross(y);
  local_from_bar.translation() = from;
  placement_ = before * local_from_bar;
  AddBlock(material, {0, -width_m / 2, -height_m / 2},
           {(to - from).norm(), width_m / 2, height_m / 2}, 1.0);
  placement_ = before;
}

void SceneBuilder::AddTurned(int material, const Eigen::Vector3d& base,
                             const std::vector<Eigen::Vector2d>& profile, int segments) {
  std::vector<double> along(profile.size(), 0);
  double widest = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    widest = std::max(widest, profile[i].x());
    if (i > 0) along[i] = along[i - 1] + (profile[i] - profile[i - 1]).norm();
  }
  const double around = 2 * M_PI * widest;
  const auto at = [&base](double radius, double height, double turn) -> Eigen::Vector3d {
    return base + Eigen::Vector3d(radius * std::cos(turn), radius * std::sin(turn), height);
  };
  const int chart = AddChart(material, {around, along.back()}, {base.x() + base.y() * 3, base.z()},
                             [=](const Eigen::Vector2d& p) -> Eigen::Vector3d {
                               return at(widest, p.y(), p.x() / widest);
                             });
  const int first = static_cast<int>(vertices_.size());
  for (std::size_t j = 0; j < profile.size(); ++j) {
    for (int i = 0; i <= segments; ++i) {
      const double turn = 2 * M_PI * i / segments;
      AddVertex(chart, at(profile[j].x(), profile[j].y(), turn), {turn * widest, along[j]});
    }
  }
  const int row = segments + 1;
  for (int j = 0; j + 1 < static_cast<int>(profile.size()); ++j) {
    for (int i = 0; i < segments; ++i) {
      const int v = first + j * row + i;
      AddTriangle(v, v + 1, v + row + 1);
      AddTriangle(v, v + row + 1, v + row);
    }
  }
}

}  // namespace colmap_ext
