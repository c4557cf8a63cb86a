#include "colmap_ext/coverage/ortho_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "colmap_ext/geom/geodesy.h"
#include "colmap_ext/geom/point_index.h"
#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

using Color = Eigen::Vector3d;  // blue, green, red; 0 … 255

Color ClassColor(CoverageClass coverage) {
  switch (coverage) {
    case CoverageClass::kUncovered:
      return {40, 40, 220};
    case CoverageClass::kCovered:
      return {60, 180, 40};
    case CoverageClass::kIgnored:
      break;
  }
  return {220, 90, 50};
}

// Rising in lightness, so that it reads without red and green.
Color ErrorColor(double error_mm, double max_error_mm) {
  const Color low(110, 40, 30), middle(140, 140, 40), high(60, 230, 250);
  const double t = error_mm < 0 ? 1 : std::min(1.0, error_mm / max_error_mm);
  return t < 0.5 ? low + 2 * t * (middle - low) : middle + (2 * t - 1) * (high - middle);
}

Color ColorOf(const IsoPoint& point, const OrthoMapOptions& options) {
  if (options.colors == "class" || point.coverage == CoverageClass::kIgnored) {
    return ClassColor(point.coverage);
  }
  return ErrorColor(point.predicted_error_mm, options.max_error_mm);
}

// Light from the north-west, as on maps.
double Shade(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d light = Eigen::Vector3d(-0.5, 0.5, 0.9).normalized();
  return 0.45 + 0.55 * std::max(0.0, normal.dot(light));
}

class ColumnPainter {
 public:
  ColumnPainter(const Surface& surface, const CoverageMap& map, const OrthoMapOptions& options)
      : mesh_(surface.mesh),
        map_(map),
        options_(options),
        scene_(surface.mesh),
        index_(Positions(map)) {
    if (map.disk_area_m2 > 0) reach_m_ = 4 * std::sqrt(map.disk_area_m2 / M_PI);
  }

  // The pixel that looks down at (x, y).
  cv::Vec4b operator()(double x, double y, const BoundingBox& box) const {
    const Eigen::Vector3d from(x, y, box.max().z());
    const double depth = box.sizes().z();
    const auto hit = scene_.Intersect(from, -Eigen::Vector3d::UnitZ(), 0, depth);
    if (!hit) return {0, 0, 0, 0};
    const Eigen::Vector3d position = from - hit->distance_m * Eigen::Vector3d::UnitZ();
    const auto nearest = index_.Nearest(position, reach_m_);
    if (!nearest) return {0, 0, 0, 0};
    const IsoPoint& point = map_.points[static_cast<std::size_t>(nearest->index)];
    Eigen::Vector3d normal = FaceNormal(mesh_, static_cast<std::size_t>(hit->face));
    if (normal.z() < 0) normal = -normal;
    const Color color = Shade(normal) * ColorOf(point, options_);
    return {static_cast<unsigned char>(color[0]), static_cast<unsigned char>(color[1]),
            static_cast<unsigned char>(color[2]), 255};
  }

 private:
  static std::vector<Eigen::Vector3d> Positions(const CoverageMap& map) {
    std::vector<Eigen::Vector3d> positions;
    for (const IsoPoint& point : map.points) positions.push_back(point.position);
    return positions;
  }

  const TriangleMesh& mesh_;
  const CoverageMap& map_;
  const OrthoMapOptions& options_;
  RayScene scene_;
  PointIndex index_;
  double reach_m_ = std::numeric_limits<double>::infinity();
};

// The six numbers of a world file, and its coordinate system as WKT (empty: local metres).
struct MapReference {
  double x_per_col = 0, y_per_col = 0, x_per_row = 0, y_per_row = 0, x = 0, y = 0;
  std::string wkt;
};

std::string UtmWkt(const UtmPosition& utm) {
  char text[900];
  std::snprintf(text, sizeof text,
                "PROJCS[\"WGS 84 / UTM zone %d%c\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\","
                "SPHEROID[\"WGS 84\",6378137,298.257223563,AUTHORITY[\"EPSG\",\"7030\"]],"
                "AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0],"
                "UNIT[\"degree\",0.0174532925199433],AUTHORITY[\"EPSG\",\"4326\"]],"
                "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
                "PARAMETER[\"central_meridian\",%d],PARAMETER[\"scale_factor\",0.9996],"
                "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",%d],"
                "UNIT[\"metre\",1],AXIS[\"Easting\",EAST],AXIS[\"Northing\",NORTH],"
                "AUTHORITY[\"EPSG\",\"%d\"]]\n",
                utm.zone, utm.is_north ? 'N' : 'S', 6 * utm.zone - 183, utm.is_north ? 0 : 10000000,
                (utm.is_north ? 32600 : 32700) + utm.zone);
  return text;
}

MapReference LocalReference(const OrthoMap& map) {
  return {map.pixel_size_m,
          0,
          0,
          -map.pixel_size_m,
          map.upper_left.x() + 0.5 * map.pixel_size_m,
          map.upper_left.y() - 0.5 * map.pixel_size_m,
          ""};
}

// The affine map through the UTM coordinates of three corner pixels.
MapReference ReferenceOf(const OrthoMap& map, const WorldFrame& frame) {
  const MapReference local = LocalReference(map);
  const int zone = frame.origin ? UtmZoneOf(*frame.origin) : 0;
  if (zone == 0) return local;
  const auto utm_of = [&](double col, double row) {
    const Eigen::Vector3d in_enu(local.x + col * map.pixel_size_m, local.y - row * map.pixel_size_m,
                                 0);
    return UtmFromGeo(GeoFromEnu(*frame.origin, in_enu), zone);
  };
  const double last_col = std::max(1, map.bgra.cols - 1), last_row = std::max(1, map.bgra.rows - 1);
  const UtmPosition first = utm_of(0, 0), right = utm_of(last_col, 0), down = utm_of(0, last_row);
  return {(right.easting_m - first.easting_m) / last_col,
          (right.northing_m - first.northing_m) / last_col,
          (down.easting_m - first.easting_m) / last_row,
          (down.northing_m - first.northing_m) / last_row,
          first.easting_m,
          first.northing_m,
          UtmWkt(first)};
}

}  // namespace

std::string OrthoMapOptions::Check() const {
  if (!(pixel_size_m >= 0)) return "OrthoMap.pixel_size_m must be >= 0 (metres; 0: automatic)";
  if (colors != "class" && colors != "error") return "OrthoMap.colors must be class or error";
  if (!(max_error_mm > 0)) return "OrthoMap.max_error_mm must be above 0";
  return "";
}

void BindOptions(OptionSet& set, OrthoMapOptions* options) {
  const std::string section = "OrthoMap";
  set.Add(section, "pixel_size_m", &options->pixel_size_m,
          "edge of a pixel on the ground, metres; 0: 1000 pixels along the longer side");
  set.Add(section, "colors", &options->colors, "class, or error: the predicted error");
  set.Add(section, "max_error_mm", &options->max_error_mm,
          "predicted error that gets the last colour, mm");
}

OrthoMap RenderOrthoMap(const Surface& surface, const CoverageMap& map,
                        const RegionOfInterest& region, const OrthoMapOptions& options) {
  ThrowIfInvalid(options.Check());
  constexpr double kMaxPixels = 1e8;
  const Eigen::Vector2d extent = region.box.sizes().head<2>();
  OrthoMap ortho;
  ortho.pixel_size_m = options.pixel_size_m > 0 ? options.pixel_size_m : extent.maxCoeff() / 1000;
  ortho.upper_left = {region.box.min().x(), region.box.max().y()};
  const Eigen::Vector2d size = (extent / ortho.pixel_size_m).array().ceil().max(1.0);
  if (!(size.prod() <= kMaxPixels)) {
    throw Error(
        "the orthographic map would have more than 10^8 pixels; raise "
        "--OrthoMap.pixel_size_m");
  }
  ortho.bgra.create(static_cast<int>(size.y()), static_cast<int>(size.x()), CV_8UC4);
  const ColumnPainter painter(surface, map, options);
  ParallelFor(ortho.bgra.rows, [&](int row) {
    const double y = ortho.upper_left.y() - (row + 0.5) * ortho.pixel_size_m;
    for (int col = 0; col < ortho.bgra.cols; ++col) {
      const double x = ortho.upper_left.x() + (col + 0.5) * ortho.pixel_size_m;
      ortho.bgra.at<cv::Vec4b>(row, col) = painter(x, y, region.box);
    }
  });
  return ortho;
}

void WriteOrthoMap(const OrthoMap& map, const WorldFrame& frame, const std::filesystem::path& png) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", map.bgra, bytes)) throw Error(png.string() + ": cannot be encoded");
  WriteFileAtomically(png, std::string(bytes.begin(), bytes.end()));
  const MapReference reference = ReferenceOf(map, frame);
  char text[400];
  std::snprintf(text, sizeof text, "%.12g\n%.12g\n%.12g\n%.12g\n%.12g\n%.12g\n",
                reference.x_per_col, reference.y_per_col, reference.x_per_row, reference.y_per_row,
                reference.x, reference.y);
  std::filesystem::path beside = png;
  WriteFileAtomically(beside.replace_extension(".pgw"), text);
  beside.replace_extension(".prj");
  if (reference.wkt.empty()) {
    std::filesystem::remove(beside);
  } else {
    WriteFileAtomically(beside, reference.wkt);
  }
}

}  // namespace colmap_ext
