#include "report/page_data.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "report/packed_array.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::int32_t>;

// Positions on the page are counted from `origin` in steps of `step_m`.
struct PageGrid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double step_m = 0.001;
};

// A step that nobody sees: 1/30000 of the bulk of the scene.
PageGrid GridOf(const std::vector<Eigen::Vector3d>& points) {
  const BoundingBox box = RobustBounds(points, 0.02);
  if (box.isEmpty()) return {};
  const double size_m = box.diagonal().norm();
  return {box.center(), size_m > 0 ? size_m / 30000 : 0.001};
}

Json VectorToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double Rounded(double value, double unit) { return std::round(value / unit) * unit; }

std::int32_t ToByte(double share) {
  return static_cast<std::int32_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

template <typename T>
std::vector<T> Reordered(const std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> sorted;
  sorted.reserve(order.size());
  for (const std::size_t i : order) sorted.push_back(values[i]);
  return sorted;
}

Json CameraToJson(const PinholeCamera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

// Sorted by name. "center": in the world; "rotation": of cam_from_world, w x y z.
Json PhotosToJson(const Reconstruction& model) {
  std::map<CameraId, std::size_t> index_of_camera;
  Json cameras = Json::array();
  for (const auto& [id, camera] : model.cameras) {
    index_of_camera[id] = cameras.size();
    cameras.push_back(CameraToJson(ToPinhole(camera)));
  }
  std::vector<const SparseImage*> images;
  for (const auto& [id, image] : model.images) images.push_back(&image);
  std::sort(images.begin(), images.end(),
            [](const SparseImage* a, const SparseImage* b) { return a->name < b->name; });
  Json photos = Json::array();
  for (const SparseImage* image : images) {
    const Eigen::Quaterniond& q = image->cam_from_world.rotation;
    const Eigen::Vector3d center = CameraCenter(image->cam_from_world);
    Json rotation = {Rounded(q.w(), 1e-9), Rounded(q.x(), 1e-9), Rounded(q.y(), 1e-9),
                     Rounded(q.z(), 1e-9)};
    photos.push_back({{"name", image->name},
                      {"camera", index_of_camera.at(image->camera_id)},
                      {"center", VectorToJson(center)},
                      {"rotation", std::move(rotation)}});
  }
  return {{"cameras", cameras}, {"list", photos}};
}

Json PointsToJson(const Reconstruction& model, const PageGrid& grid) {
  std::vector<Eigen::Vector3d> positions;
  std::vector<const SparsePoint*> points;
  for (const auto& [id, point] : model.points) {
    positions.push_back(point.position);
    points.push_back(&point);
  }
  const std::vector<std::size_t> order = SpatialOrder(positions);
  Bytes colors, lengths;
  for (const std::size_t i : order) {
    for (int k = 0; k < 3; ++k) colors.push_back(points[i]->color[k]);
    lengths.push_back(static_cast<std::int32_t>(points[i]->track.size()));
  }
  return {{"position", PackPositions(Reordered(positions, order), grid.origin, grid.step_m)},
          {"color", PackIntegers(colors, 3)},
          {"photos", PackIntegers(lengths, 1)}};
}

Json SurfaceToJson(const Surface& surface, const PageGrid& grid) {
  const std::vector<std::size_t> order = SpatialOrder(surface.mesh.vertices);
  std::vector<std::int32_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<std::int32_t>(i);
  std::vector<Eigen::Vector3i> faces;
  for (const Eigen::Vector3i& face : surface.mesh.faces) {
    Eigen::Vector3i moved;
    for (int k = 0; k < 3; ++k) moved[k] = place[static_cast<std::size_t>(face[k])];
    int first = 0;  // the smallest corner first: differences between faces stay small
    moved.minCoeff(&first);
    faces.emplace_back(moved[first], moved[(first + 1) % 3], moved[(first + 2) % 3]);
  }
  std::sort(faces.begin(), faces.end(), [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  Bytes corners;
  for (const Eigen::Vector3i& face : faces) corners.insert(corners.end(), face.begin(), face.end());
  Json json = {{"position",
                PackPositions(Reordered(surface.mesh.vertices, order), grid.origin, grid.step_m)},
               {"face", PackIntegers(corners, 3)}};
  if (!surface.color.empty()) {
    Bytes colors;
    for (const std::size_t i : order) {
      for (int k = 0; k < 3; ++k) colors.push_back(ToByte(surface.color[i][k]));
    }
    json["color"] = PackIntegers(colors, 3);
  }
  return json;
}

Json CoverageToJson(const CoverageMap& map, const PageGrid& grid) {
  std::vector<Eigen::Vector3d> positions;
  for (const IsoPoint& point : map.points) positions.push_back(point.position);
  const std::vector<std::size_t> order = SpatialOrder(positions);
  Bytes normals, classes, views, errors, scores;
  for (const std::size_t i : order) {
    const IsoPoint& point = map.points[i];
    for (int k = 0; k < 3; ++k) {
      normals.push_back(static_cast<std::int32_t>(std::lround(127 * point.normal[k])));
    }
    classes.push_back(static_cast<std::int32_t>(point.coverage));
    views.push_back(point.num_good_views);
    const double error_um = std::clamp(1000 * point.predicted_error_mm, -1.0, 2e9);
    errors.push_back(static_cast<std::int32_t>(point.predicted_error_mm < 0 ? -1 : error_um));
    scores.push_back(ToByte(point.score));
  }
  Json json = {
      {"position", PackPositions(Reordered(positions, order), grid.origin, grid.step_m)},
      {"normal", PackIntegers(normals, 3)},
      {"class", PackIntegers(classes, 1)},
      {"good_views", PackIntegers(views, 1)},
      {"disk_radius_m", std::sqrt(map.disk_area_m2 / M_PI)},
      {"counts",
       {map.Count(CoverageClass::kUncovered), map.Count(CoverageClass::kCovered),
        map.Count(CoverageClass::kIgnored)}},
  };
  const bool has_errors = std::any_of(errors.begin(), errors.end(), [](int e) { return e >= 0; });
  if (has_errors) json["predicted_error_um"] = PackIntegers(errors, 1);
  // Maps of before there were scores have 0 everywhere.
  const bool has_scores = std::any_of(scores.begin(), scores.end(), [](int s) { return s > 0; });
  if (has_scores) json["score_255"] = PackIntegers(scores, 1);
  return json;
}

std::vector<Eigen::Vector3d> PositionsOf(const Reconstruction& model) {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& [id, point] : model.points) positions.push_back(point.position);
  return positions;
}

void AddJsonFile(const char* key, const fs::path& path, Json* json) {
  if (fs::exists(path)) (*json)[key] = ReadJsonFile(path);
}

}  // namespace

Json IterationForPage(const IterationFiles& files) {
  const Reconstruction model = ReadReconstruction(files.sparse());
  const PageGrid grid = GridOf(PositionsOf(model));
  Json json = {{"origin", VectorToJson(grid.origin)},
               {"photos", PhotosToJson(model)},
               {"points", PointsToJson(model, grid)}};
  if (fs::exists(files.surface_ply())) {
    json["surface"] = SurfaceToJson(ReadSurface(files.surface_ply()), grid);
  }
  if (fs::exists(files.coverage_ply())) {
    json["coverage"] = CoverageToJson(ReadCoverageMap(files.coverage_ply()), grid);
  }
  AddJsonFile("frame", files.frame_json(), &json);
  AddJsonFile("summary", files.coverage_json(), &json);
  AddJsonFile("views", files.views_json(), &json);
  AddJsonFile("path", files.path_json(), &json);
  return json;
}

Json FusedCloudForPage(const IterationFiles& files, int max_points) {
  if (max_points <= 0 || !fs::exists(files.fused_ply())) return {};
  const OrientedPoints cloud = ReadOrientedPoints(files.fused_ply());
  const auto limit = static_cast<std::size_t>(max_points);
  const std::size_t kept = std::min(cloud.size(), limit);
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::size_t> source;
  for (std::size_t i = 0; i < kept; ++i) {
    source.push_back(i * cloud.size() / kept);
    positions.push_back(cloud[source.back()].position);
  }
  const PageGrid grid = GridOf(positions);
  const std::vector<std::size_t> order = SpatialOrder(positions);
  Bytes colors;
  for (const std::size_t i : order) {
    for (int k = 0; k < 3; ++k) colors.push_back(cloud[source[i]].color[k]);
  }
  return {{"origin", VectorToJson(grid.origin)},
          {"total", cloud.size()},
          {"position", PackPositions(Reordered(positions, order), grid.origin, grid.step_m)},
          {"color", PackIntegers(colors, 3)}};
}

}  // namespace colmap_ext
