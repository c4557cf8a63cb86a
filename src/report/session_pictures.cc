#include "colmap_ext/report/session_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/report/picture_overlay.h"
#include "colmap_ext/util/parallel.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

const Rgb kNeutral(0.84f, 0.83f, 0.81f);
const Rgb kUnsampled(0.72f, 0.73f, 0.75f);
const Rgb kPhotoColor(0.20f, 0.34f, 0.48f);
const Rgb kViewColor(0.80f, 0.33f, 0.04f);
const Rgb kDroppedColor(0.47f, 0.48f, 0.50f);
const Rgb kPathColor(0.42f, 0.18f, 0.62f);

// 12345 -> "12,345".
std::string Grouped(std::size_t count) {
  std::string text = std::to_string(count);
  for (auto i = static_cast<int>(text.size()) - 3; i > 0; i -= 3) {
    text.insert(static_cast<std::size_t>(i), ",");
  }
  return text;
}

PictureCamera CameraFor(const PictureView& view, const std::vector<Eigen::Vector3d>& by_default) {
  const auto& focus = view.focus.empty() ? by_default : view.focus;
  // A model that came out empty still gets its (empty) picture.
  return FitCamera(focus.empty() ? std::vector<Eigen::Vector3d>{Eigen::Vector3d::Zero()} : focus,
                   view.direction, view.size);
}

// What frames a mesh: its vertices without the outermost hundredth on each side, thinned.
std::vector<Eigen::Vector3d> BulkOf(const TriangleMesh& mesh) {
  const BoundingBox box = RobustBounds(mesh.vertices, 0.01);
  std::vector<Eigen::Vector3d> bulk;
  const std::size_t step = mesh.vertices.size() / 5000 + 1;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) {
    if (box.contains(mesh.vertices[i])) bulk.push_back(mesh.vertices[i]);
  }
  return bulk.empty() && !box.isEmpty() ? CornersOf(box) : bulk;
}

// Finds the class of surface points. Most faces lie within one class: their corners tell it, and
// only the others are looked up point by point.
class ClassLookup {
 public:
  ClassLookup(const TriangleMesh& mesh, const CoverageMap& map)
      : map_(map), index_(Positions(map)) {
    // Iso-points are Poisson-disk samples: one is never much further than the radius of two disks.
    if (map.disk_area_m2 > 0) reach_ = 4 * std::sqrt(map.disk_area_m2 / M_PI);
    std::vector<int> class_of_vertex(mesh.vertices.size());
    ParallelFor(mesh.vertices.size(),
                [&](std::size_t i) { class_of_vertex[i] = Find(mesh.vertices[i]); });
    class_of_face_.assign(mesh.faces.size(), kMixed);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto corner = [&](int k) { return static_cast<std::size_t>(mesh.faces[f][k]); };
      double longest = 0;
      for (int k = 0; k < 3; ++k) {
        longest = std::max(longest,
                           (mesh.vertices[corner(k)] - mesh.vertices[corner((k + 1) % 3)]).norm());
      }
      const int first = class_of_vertex[corner(0)];
      const bool is_small = std::isfinite(reach_) && longest < 0.5 * reach_;
      if (is_small && first == class_of_vertex[corner(1)] && first == class_of_vertex[corner(2)]) {
        class_of_face_[f] = first;
      }
    }
  }

  Rgb operator()(const RayHit& hit, const Eigen::Vector3d& position) const {
    int found = class_of_face_[static_cast<std::size_t>(hit.face)];
    if (found == kMixed) found = Find(position);
    return found == kNone ? kUnsampled : ColorOf(static_cast<CoverageClass>(found));
  }

 private:
  static constexpr int kMixed = -2;
  static constexpr int kNone = -1;  // no iso-point near

  static std::vector<Eigen::Vector3d> Positions(const CoverageMap& map) {
    std::vector<Eigen::Vector3d> positions;
    for (const IsoPoint& point : map.points) positions.push_back(point.position);
    return positions;
  }

  int Find(const Eigen::Vector3d& position) const {
    const auto nearest = index_.Nearest(position, reach_);
    if (!nearest) return kNone;
    return static_cast<int>(map_.points[static_cast<std::size_t>(nearest->index)].coverage);
  }

  const CoverageMap& map_;
  PointIndex index_;
  double reach_ = std::numeric_limits<double>::infinity();
  std::vector<int> class_of_face_;
};

// ">" marks along the path, `size_px` long at the camera's distance.
std::vector<Polyline3d> Arrows(const Polyline3d& path, const PictureCamera& camera,
                               double size_px) {
  std::vector<Polyline3d> arrows;
  const Eigen::Vector3d eye = CameraCenter(camera.cam_from_world);
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Eigen::Vector3d tip = 0.45 * path[i] + 0.55 * path[i + 1];
    const double depth = (camera.cam_from_world * tip).z();
    const double length = size_px * depth / camera.camera.fx;
    const Eigen::Vector3d step = path[i + 1] - path[i];
    const Eigen::Vector3d side = step.cross(tip - eye);
    if (depth <= 0 || step.norm() < 3.5 * length || side.norm() < 1e-12) continue;
    const Eigen::Vector3d back = tip - length * step.normalized();
    arrows.push_back(
        {back + 0.6 * length * side.normalized(), tip, back - 0.6 * length * side.normalized()});
  }
  return arrows;
}

// Number of each view in the order in which the path visits it, from 1.
std::map<int, int> TourOrder(const FlightPath& path) {
  std::map<int, int> number_of_view;
  for (const Waypoint& waypoint : path.waypoints) {
    if (waypoint.view_id < 0) continue;
    number_of_view.emplace(waypoint.view_id, static_cast<int>(number_of_view.size()) + 1);
  }
  return number_of_view;
}

PinholeCamera PlannedCamera(const FlightPicture& flight) {
  if (flight.planned_camera.width > 0) return flight.planned_camera;
  if (!flight.photos.empty()) return flight.photos.front().camera;
  return {640, 368, 500, 500, 320, 184};
}

std::vector<Eigen::Vector3d> FlightFocus(const TriangleMesh& mesh, const FlightPicture& flight) {
  std::vector<Eigen::Vector3d> focus = BulkOf(mesh);
  for (const PosedPhoto& photo : flight.photos) {
    focus.push_back(CameraCenter(photo.cam_from_world));
  }
  for (const PlannedView& view : flight.views) focus.push_back(view.position);
  for (const Waypoint& waypoint : flight.path.waypoints) focus.push_back(waypoint.position);
  return focus;
}

void DrawPhotos(const FlightPicture& flight, double frustum_m, Picture* picture) {
  std::vector<Polyline3d> lines;
  for (const PosedPhoto& photo : flight.photos) {
    const auto frustum = FrustumLines(photo.camera, photo.cam_from_world, frustum_m);
    lines.insert(lines.end(), frustum.begin(), frustum.end());
  }
  DrawPolylines(lines,
                {.color = kPhotoColor, .width_px = 1.1, .opacity = 0.8, .hidden_opacity = 0.12},
                picture);
}

void DrawPath(const FlightPicture& flight, Picture* picture) {
  Polyline3d path;
  for (const Waypoint& waypoint : flight.path.waypoints) path.push_back(waypoint.position);
  if (path.size() < 2) return;
  std::vector<Polyline3d> lines = Arrows(path, picture->camera, 9);
  lines.push_back(path);
  DrawPolylines(lines, {.color = kPathColor, .width_px = 3, .hidden_opacity = 0.3, .halo_px = 1.3},
                picture);
}

void DrawViews(const FlightPicture& flight, double frustum_m, Picture* picture) {
  const std::map<int, int> number_of_view = TourOrder(flight.path);
  const PinholeCamera camera = PlannedCamera(flight);
  for (const PlannedView& view : flight.views) {
    const bool is_flown = number_of_view.empty() || number_of_view.contains(view.id);
    const Rgb color = is_flown ? kViewColor : kDroppedColor;
    const auto lines = FrustumLines(camera, CamFromWorld(view.position, view.direction), frustum_m);
    FillPolygon(lines.front(), color, 0.35, picture);
    DrawPolylines(lines, {.color = color, .width_px = 1.8, .halo_px = 0.8}, picture);
  }
  for (const PlannedView& view : flight.views) {
    const auto number = number_of_view.find(view.id);
    const auto pixel = ProjectToPicture(picture->camera, view.position);
    if (number == number_of_view.end() || !pixel) continue;
    DrawBadge(std::to_string(number->second), *pixel, 10, kViewColor, &picture->bgr);
  }
  if (flight.path.waypoints.empty()) return;
  const auto start = ProjectToPicture(picture->camera, flight.path.waypoints.front().position);
  if (start && flight.path.waypoints.front().view_id < 0) {
    DrawBadge("start", *start, 9, kPathColor, &picture->bgr);
  }
}

void DrawFlightLegend(const FlightPicture& flight, cv::Mat* bgr) {
  std::vector<LegendRow> rows = {
      {kPhotoColor, "photos so far", Grouped(flight.photos.size()), true},
      {kViewColor, "next views", Grouped(flight.views.size()), false}};
  if (!flight.path.dropped_view_ids.empty()) {
    rows.push_back({kDroppedColor, "views without a safe path",
                    Grouped(flight.path.dropped_view_ids.size()), false});
  }
  if (flight.path.waypoints.size() > 1) {
    rows.push_back({kPathColor, "path",
                    FormatNumber("%.0f m", flight.path.length_m) +
                        FormatNumber(", %.0f s", flight.path.duration_s),
                    true});
    rows.push_back({kPathColor, "smallest clearance",
                    FormatNumber("%.1f m", flight.path.min_clearance_m), true});
  }
  DrawLegend("Flight path", rows, bgr);
}

}  // namespace

Rgb ColorOf(CoverageClass coverage) {
  switch (coverage) {
    case CoverageClass::kCovered:
      return {0.36f, 0.74f, 0.52f};
    case CoverageClass::kUncovered:
      return {0.86f, 0.26f, 0.18f};
    case CoverageClass::kIgnored:
      return {0.52f, 0.66f, 0.90f};
  }
  return kUnsampled;
}

std::vector<Eigen::Vector3d> FocusOf(const CoverageMap& map, const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  for (const IsoPoint& point : map.points) {
    if (point.coverage != CoverageClass::kIgnored) points.push_back(point.position);
  }
  return points.empty() ? BulkOf(mesh) : points;
}

cv::Mat RenderSurface(const MeshPainter& painter, const Surface& surface, const PictureView& view) {
  const ColorAt color =
      surface.color.empty() ? ConstantColor(kNeutral) : VertexColors(painter.mesh(), surface.color);
  return painter.Render(color, CameraFor(view, BulkOf(painter.mesh()))).bgr;
}

cv::Mat RenderCoverageMap(const MeshPainter& painter, const CoverageMap& map,
                          const PictureView& view) {
  const ClassLookup lookup(painter.mesh(), map);
  const ColorAt color = [&lookup](const RayHit& hit, const Eigen::Vector3d& position) {
    return lookup(hit, position);
  };
  cv::Mat bgr = painter.Render(color, CameraFor(view, FocusOf(map, painter.mesh()))).bgr;
  std::vector<LegendRow> rows;
  for (const auto& [coverage, label] : {std::pair{CoverageClass::kCovered, "covered"},
                                        {CoverageClass::kUncovered, "uncovered"},
                                        {CoverageClass::kIgnored, "ignored"}}) {
    rows.push_back({ColorOf(coverage), label, Grouped(map.Count(coverage)), false});
  }
  DrawLegend("Coverage " + FormatNumber("%.1f %%", 100 * map.CoveredRatio()), rows, &bgr);
  return bgr;
}

cv::Mat RenderFlightPath(const MeshPainter& painter, const FlightPicture& flight,
                         const PictureView& view) {
  const PictureCamera camera = CameraFor(view, FlightFocus(painter.mesh(), flight));
  Picture picture = painter.Render(ConstantColor(kNeutral), camera);
  // Frusta of about 2 % of the picture's width where the object is.
  const BoundingBox box = RobustBounds(painter.mesh().vertices, 0.01);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  if (!box.isEmpty()) middle = box.center();
  const double depth = std::max((camera.cam_from_world * middle).z(), 1e-3);
  const double frustum_m = 0.022 * view.size.width * depth / camera.camera.fx;
  DrawPhotos(flight, 0.7 * frustum_m, &picture);
  DrawPath(flight, &picture);
  DrawViews(flight, 1.3 * frustum_m, &picture);
  DrawFlightLegend(flight, &picture.bgr);
  return picture.bgr;
}

}  // namespace colmap_ext
