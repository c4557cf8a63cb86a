#include "report/made_up_workspace.h"

#include <cmath>

#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/report/view_overlay.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/files.h"
#include "report/made_up_session.h"

namespace colmap_ext {
namespace {

// A plane spanned by `u` and `v` from `corner`, in n x n cells of alternating brightness.
void AddPatch(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
              int n, const Eigen::Vector3d& color, MadeUpHouse* house) {
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int first = static_cast<int>(house->mesh.vertices.size());
      const double shade = (i + j) % 2 == 0 ? 1.0 : 0.8;
      for (const auto& [a, b] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}) {
        house->mesh.vertices.push_back(corner + u * a / n + v * b / n);
        house->vertex_color.push_back(color * shade);
      }
      house->mesh.faces.emplace_back(first, first + 1, first + 2);
      house->mesh.faces.emplace_back(first, first + 2, first + 3);
    }
  }
}

ViewDirection DirectionTo(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d way = to - from;
  return {std::atan2(way.x(), way.y()), std::atan2(way.z(), std::hypot(way.x(), way.y()))};
}

Rigid3d PoseOf(int photo) {
  const double angle = 0.9 * photo;
  const Eigen::Vector3d center(11 * std::cos(angle), 11 * std::sin(angle), 5 + photo % 3);
  return CamFromWorld(center, DirectionTo(center, {0, 0, 1.5}));
}

std::string NameOf(int photo) { return "photo_" + std::to_string(100 + photo) + ".jpg"; }

Reconstruction ModelOf(const MadeUpHouse& house, int photos) {
  Reconstruction model;
  const PinholeCamera& c = kHouseCamera;
  model.cameras[1] = {CameraModel::kPinhole, c.width, c.height, {c.fx, c.fy, c.cx, c.cy}};
  for (int i = 0; i < photos; ++i) {
    SparseImage image;
    image.name = NameOf(i);
    image.camera_id = 1;
    image.cam_from_world = PoseOf(i);
    model.images[static_cast<ImageId>(i + 1)] = image;
  }
  for (const SurfaceSample& sample : SampleUniformly(house.mesh, 900, 1)) {
    SparsePoint point;
    point.position = sample.position;
    const auto vertex =
        static_cast<std::size_t>(house.mesh.faces[static_cast<std::size_t>(sample.face)][0]);
    point.color = (255 * house.vertex_color[vertex]).cast<std::uint8_t>();
    model.points[model.points.size() + 1] = point;
  }
  return model;
}

// Covered from the east on; later iterations cover more.
CoverageMap CoverageOf(const MadeUpHouse& house, int iteration, int iterations) {
  CoverageMap map;
  map.disk_area_m2 = M_PI * 0.2 * 0.2;
  map.min_projection_ratio = 400;
  const double covered_below = 8.0 * (iteration + 1) / iterations - 2;
  for (const SurfaceSample& sample : SamplePoissonDisk(house.mesh, 0.4, 2)) {
    IsoPoint point;
    point.position = sample.position;
    point.normal = sample.normal;
    const double away = std::abs(sample.position.x());
    point.coverage = away > 6.5             ? CoverageClass::kIgnored
                     : away < covered_below ? CoverageClass::kCovered
                                            : CoverageClass::kUncovered;
    point.num_good_views = point.coverage == CoverageClass::kCovered ? 3 + iteration : 1;
    point.predicted_error_mm = point.coverage == CoverageClass::kUncovered ? -1 : 5 + 3 * away;
    point.score = std::clamp(1 - away / 8, 0.0, 1.0);
    map.points.push_back(point);
  }
  return map;
}

void WritePlan(const IterationFiles& files, int iteration) {
  std::vector<PlannedView> views;
  FlightPath path;
  path.waypoints.push_back({{0, -12, 6}, {0, -0.3}, -1});
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d position(-9.0 + 2 * i, 10 + 0.5 * iteration, 6);
    views.push_back({10 * iteration + i, position, DirectionTo(position, {0, 0, 2}), 10.0 - i});
    path.waypoints.push_back({position, views.back().direction, views.back().id});
  }
  path.length_m = 41.5;
  path.duration_s = 33;
  path.min_clearance_m = 3.25;
  const WorldFrame frame{true, GeoPosition{47.4, 8.5, 400}};
  WriteViews(views, frame, files.views_json());
  WritePath(path, frame, files.path_json());
  WriteWorldFrame(frame, files.frame_json());
}

// Two superpixels of two triangles; the last triangle without support.
ViewMesh OverlayOf(const Rigid3d& cam_from_world) {
  ViewMesh mesh;
  mesh.camera = kHouseCamera;
  mesh.cam_from_world = cam_from_world;
  mesh.image.vertices_px = {{0, 0}, {240, 0}, {480, 0}, {0, 320}, {240, 320}, {480, 320}};
  mesh.image.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  mesh.image.superpixel = {0, 0, 1, 1};
  mesh.image.num_superpixels = 2;
  mesh.confidence = {1.0f, 0.75f, 0.25f, 0.5f};
  mesh.supported = {1, 1, 1, 0};
  return mesh;
}

void WriteIteration(const MadeUpHouse& house, const Workspace& workspace, int iteration,
                    int iterations) {
  const IterationFiles files{workspace.iteration(iteration)};
  const int count = PhotosOfIteration(iteration);
  const Reconstruction model = ModelOf(house, count);
  WriteReconstructionBinary(model, files.sparse());
  const std::size_t vertices = house.mesh.vertices.size();
  Surface surface{house.mesh, std::vector<double>(vertices, 0.02),
                  std::vector<double>(vertices, 0.005), house.vertex_color};
  WriteSurface(surface, files.surface_ply());
  const CoverageMap map = CoverageOf(house, iteration, iterations);
  WriteCoverageMap(map, files.coverage_ply());
  WriteCoverageSummary(map, {{"max_incidence_deg", 80}}, files.coverage_json());
  WritePlan(files, iteration);
  OrientedPoints cloud;
  for (const SurfaceSample& sample : SampleUniformly(house.mesh, 4000, 3)) {
    cloud.push_back({sample.position, sample.normal, {200, 180, 160}, 0.9f, 0});
  }
  WriteOrientedPoints(cloud, files.fused_ply());
  const PhotoSet photos = LoadPhotoSet(model, "", false);
  std::vector<ViewMesh> views;
  for (const PosedPhoto& photo : photos.photos) views.push_back(OverlayOf(photo.cam_from_world));
  WriteViewOverlays(photos, views, files.folder / "overlays.json");
  WritePng(cv::Mat(40, 64, CV_8UC3, cv::Scalar(200, 180, 160)), files.pictures() / "surface.png");
}

}  // namespace

MadeUpHouse MakeHouse() {
  MadeUpHouse house;
  const Eigen::Vector3d x(4, 0, 0), y(0, 6, 0), z(0, 0, 3), corner(-2, -3, 0);
  const Eigen::Vector3d wall(0.85, 0.78, 0.66), tiles(0.7, 0.32, 0.25), lawn(0.42, 0.58, 0.33);
  AddPatch({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}, 16, lawn, &house);
  AddPatch(corner, x, z, 8, wall, &house);
  AddPatch(corner + x, y, z, 8, wall, &house);
  AddPatch(corner + x + y, -x, z, 8, wall, &house);
  AddPatch(corner + y, -y, z, 8, wall, &house);
  AddPatch(corner + z, {2, 0, 2}, y, 8, tiles, &house);
  AddPatch(corner + z + x + y, {-2, 0, 2}, -y, 8, tiles, &house);
  return house;
}

void MakeWorkspace(const std::filesystem::path& root, int iterations) {
  const Workspace workspace(root);
  const MadeUpHouse house = MakeHouse();
  SessionSummary summary = MadeUpSession(iterations);
  const MeshPainter painter(house.mesh);
  const ColorAt color = VertexColors(painter.mesh(), house.vertex_color);
  for (int i = 0; i < iterations; ++i) {
    auto& iteration = summary.iterations[static_cast<std::size_t>(i)];
    iteration.photos = iteration.registered = PhotosOfIteration(i);
    iteration.unregistered.clear();
    WriteIteration(house, workspace, i, iterations);
  }
  for (int i = 0; i < PhotosOfIteration(iterations - 1); ++i) {
    WritePhoto(painter.Render(color, {kHouseCamera, PoseOf(i)}).bgr,
               workspace.images() / NameOf(i));
  }
  WriteSummary(summary, workspace.summary_json());
  WriteFileAtomically(workspace.state_json(),
                      "{\"version\": 1, \"source\": \"scene house\", \"iterations_done\": 0}\n");
}

}  // namespace colmap_ext
