#include "judged.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr std::uint64_t kSampleSeed = 3;

std::vector<SurfaceSample> TruthSamples(const Site& site, double spacing_m) {
  std::vector<bool> in_region(site.truth.faces.size());
  for (std::size_t f = 0; f < in_region.size(); ++f) {
    BoundingBox bounds;
    for (int k = 0; k < 3; ++k) {
      bounds.extend(site.truth.vertices[static_cast<std::size_t>(site.truth.faces[f][k])]);
    }
    in_region[f] = site.region.intersects(bounds);
  }
  std::vector<SurfaceSample> samples =
      SamplePoissonDisk(site.truth, spacing_m, kSampleSeed, in_region);
  std::erase_if(samples, [&](const SurfaceSample& s) { return !site.region.contains(s.position); });
  return samples;
}

// The nearest sample that faces the same way; among the nearest few hundred, else the nearest.
std::size_t NearestFacing(const PointIndex& index, const std::vector<SurfaceSample>& samples,
                          const IsoPoint& point) {
  for (const std::size_t count : {8U, 400U}) {
    for (const PointNeighbor& neighbor : index.NearestOf(point.position, count)) {
      const auto i = static_cast<std::size_t>(neighbor.index);
      if (samples[i].normal.dot(point.normal) > 0) return i;
    }
  }
  return static_cast<std::size_t>(index.NearestOf(point.position, 1).front().index);
}

double MedianOf(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

std::vector<CloudAround> LookAtCloud(const std::vector<IsoPoint>& points,
                                     const OrientedPoints& cloud, double iso_spacing_m) {
  constexpr std::size_t kNeighbors = 25;
  std::vector<Eigen::Vector3d> positions;
  for (const OrientedPoint& point : cloud) positions.push_back(point.position);
  const PointIndex index(positions);
  std::vector<CloudAround> around(points.size());
  ParallelFor(points.size(), [&](std::size_t i) {
    const auto neighbors = index.NearestOf(points[i].position, kNeighbors);
    double smooth = 0;
    for (const PointNeighbor& neighbor : neighbors) {
      const Eigen::Vector3d& at = positions[static_cast<std::size_t>(neighbor.index)];
      const double offset = 4 * points[i].normal.dot(at - points[i].position) / iso_spacing_m;
      smooth += std::exp(-offset * offset);
    }
    // A point far from all of the cloud stays comparable with the others.
    constexpr double kLeastSmoothness = 1e-12;
    around[i] = {neighbors.back().distance * std::sqrt(M_PI / (kNeighbors - 1.0)),
                 std::max(kLeastSmoothness, smooth / static_cast<double>(neighbors.size()))};
  });
  return around;
}

// The samples that an iso-point stands for, by the errors there.
double TrueError(const PointIndex& index, const std::vector<SurfaceSample>& samples,
                 const std::vector<double>& errors, std::size_t nearest, double radius_m) {
  constexpr std::size_t kCandidates = 40;
  std::vector<double> around;
  for (const PointNeighbor& neighbor : index.NearestOf(samples[nearest].position, kCandidates)) {
    const auto i = static_cast<std::size_t>(neighbor.index);
    if (neighbor.distance > radius_m || samples[i].normal.dot(samples[nearest].normal) <= 0) {
      continue;
    }
    around.push_back(errors[i]);
  }
  return MedianOf(&around);
}

// `iso_points`: an index of the map's.
double Unrepresented(const std::vector<SurfaceSample>& samples, const PointIndex& iso_points,
                     double reach_m) {
  double count = 0;
  for (const SurfaceSample& sample : samples) {
    count += !iso_points.Nearest(sample.position, reach_m);
  }
  return count / static_cast<double>(samples.size());
}

// Of the samples of the truth, by what the map has there.
std::vector<JudgedPlace> JudgePlaces(const std::vector<SurfaceSample>& samples,
                                     const std::vector<double>& errors,
                                     const std::vector<IsoPoint>& points,
                                     const PointIndex& iso_points, double spacing_m) {
  constexpr std::size_t kCandidates = 12;
  std::vector<JudgedPlace> places;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    JudgedPlace place{0, false, errors[i]};
    bool is_ignored = false;
    for (const PointNeighbor& neighbor : iso_points.NearestOf(samples[i].position, kCandidates)) {
      const IsoPoint& point = points[static_cast<std::size_t>(neighbor.index)];
      if (neighbor.distance > spacing_m) break;
      if (point.normal.dot(samples[i].normal) <= 0) continue;
      is_ignored = point.coverage == CoverageClass::kIgnored;
      place.score = point.score;
      place.is_covered = point.coverage == CoverageClass::kCovered;
      break;
    }
    if (!is_ignored) places.push_back(place);
  }
  return places;
}

void LookAround(const ErrorModel& model, std::vector<JudgedPoint>* points) {
  std::vector<Eigen::Vector3d> positions;
  std::vector<CueLogs> logs;
  for (const JudgedPoint& judged : *points) {
    positions.push_back(judged.point.position);
    logs.push_back(LogsOf(judged.cues, model));
  }
  const std::vector<CueLogs> around = MeanLogsAround(positions, logs, model.neighbors);
  for (std::size_t i = 0; i < around.size(); ++i) (*points)[i].around = around[i];
}

}  // namespace

double JudgedFlight::FarShare() const {
  double far = 0;
  for (const JudgedPoint& point : points) far += point.distance_to_truth_m > 1.5 * spacing_m;
  return far / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

JudgedFlight Judge(const Site& site, const FlightModels& models, const CoverageOptions& options,
                   const JobControl& job) {
  const Surface surface = ReadSurface(models.surface);
  const PhotoSet photos = LoadPhotoSet(ReadReconstruction(models.sparse), "", false);
  const CoverageMap map = EvaluateCoverage(surface, photos.photos, {site.region}, options, job);
  CoverageOptions paper_options = options;
  paper_options.target_error_mm = 0;
  const CoverageMap paper =
      EvaluateCoverage(surface, photos.photos, {site.region}, paper_options, job);
  JudgedFlight judged;
  judged.spacing_m = std::sqrt(0.7 * map.disk_area_m2);
  const std::vector<SurfaceSample> samples = TruthSamples(site, judged.spacing_m / 3);
  std::vector<Eigen::Vector3d> positions, centers;
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  for (const PosedPhoto& photo : photos.photos) {
    centers.push_back(CameraCenter(photo.cam_from_world));
  }
  const std::vector<double> errors = DistancesTo(ReadMesh(models.dense_surface), positions);
  const std::vector<CloudAround> cloud =
      LookAtCloud(map.points, ReadOrientedPoints(models.fused), judged.spacing_m);
  const PointIndex index(positions);
  const VisibilityEngine engine(surface.mesh, options.visibility);
  std::vector<JudgedPoint> points(map.points.size());
  ParallelFor(points.size(), [&](std::size_t i) {
    const IsoPoint& point = map.points[i];
    if (point.coverage == CoverageClass::kIgnored) return;
    const std::size_t nearest = NearestFacing(index, samples, point);
    points[i] = {point,
                 TrueError(index, samples, errors, nearest, 0.6 * judged.spacing_m),
                 (samples[nearest].position - point.position).norm(),
                 CuesOf(ViewsOf(point.position, point.normal, photos.photos, centers, engine),
                        point.scatter_m, DegToRad(options.error_model.max_angle_deg)),
                 {},
                 paper.points[i].coverage,
                 cloud[i]};
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (map.points[i].coverage != CoverageClass::kIgnored) judged.points.push_back(points[i]);
  }
  LookAround(options.error_model, &judged.points);
  std::vector<Eigen::Vector3d> iso_positions;
  for (const IsoPoint& point : map.points) iso_positions.push_back(point.position);
  const PointIndex iso_points(iso_positions);
  judged.places = JudgePlaces(samples, errors, map.points, iso_points, judged.spacing_m);
  judged.unrepresented = Unrepresented(samples, iso_points, 1.5 * judged.spacing_m);
  return judged;
}

}  // namespace colmap_ext
