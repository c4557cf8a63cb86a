#include "colmap_ext/report/mesh_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Strengths of the lights; a white surface that faces the sun is just below 1.
constexpr float kSky = 0.62f;     // from above
constexpr float kGround = 0.46f;  // reflected from below
constexpr float kSun = 0.42f;
constexpr float kInShadow = 0.3f;  // share of the sun that is left: colours must stay readable

cv::Vec3b ToBgr(const Rgb& color) {
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
  };
  return {byte(color[2]), byte(color[1]), byte(color[0])};
}

// Largest difference of a channel between a pixel and the four around it.
double LargestStep(const cv::Mat& image, int y, int x) {
  const cv::Vec3f& center = image.at<cv::Vec3f>(y, x);
  float largest = 0;
  const auto compare = [&](const cv::Vec3f& other) {
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(other[k] - center[k]));
  };
  compare(image.at<cv::Vec3f>(std::max(y - 1, 0), x));
  compare(image.at<cv::Vec3f>(std::min(y + 1, image.rows - 1), x));
  compare(image.at<cv::Vec3f>(y, std::max(x - 1, 0)));
  compare(image.at<cv::Vec3f>(y, std::min(x + 1, image.cols - 1)));
  return largest;
}

// For each corner of each face the mean of the normals of the faces around the vertex that meet
// this one at less than the crease angle.
std::vector<Eigen::Vector3f> CornerNormals(const TriangleMesh& mesh, double crease_rad) {
  std::vector<Eigen::Vector3f> scaled(mesh.faces.size());
  std::vector<Eigen::Vector3f> unit(mesh.faces.size());
  std::vector<int> first(mesh.vertices.size() + 1, 0);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto unit_normal = FaceNormal(mesh, f);
    unit[f] = unit_normal.cast<float>();
    scaled[f] = (unit_normal * FaceArea(mesh, f)).cast<float>();
    for (int k = 0; k < 3; ++k) ++first[static_cast<std::size_t>(mesh.faces[f][k]) + 1];
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) first[v + 1] += first[v];
  std::vector<int> faces_around(mesh.faces.size() * 3);
  std::vector<int> next = first;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      int& slot = next[static_cast<std::size_t>(mesh.faces[f][k])];
      faces_around[static_cast<std::size_t>(slot++)] = static_cast<int>(f);
    }
  }
  const auto limit = static_cast<float>(std::cos(crease_rad));
  std::vector<Eigen::Vector3f> normals(mesh.faces.size() * 3);
  ParallelFor(mesh.faces.size(), [&](std::size_t f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(mesh.faces[f][static_cast<int>(k)]);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = first[vertex]; i < first[vertex + 1]; ++i) {
        const auto other = static_cast<std::size_t>(faces_around[static_cast<std::size_t>(i)]);
        if (other == f || unit[other].dot(unit[f]) > limit) sum += scaled[other];
      }
      const float length = sum.norm();
      normals[3 * f + k] = length > 0 ? Eigen::Vector3f(sum / length) : unit[f];
    }
  });
  return normals;
}

}  // namespace

PictureCamera FitCamera(const std::vector<Eigen::Vector3d>& points, const ViewDirection& direction,
                        const cv::Size& size, double margin, double fov_rad) {
  if (points.empty()) throw Error("a picture needs something to show, but there are no points");
  PictureCamera result;
  const double focal = 0.5 * size.width / std::tan(0.5 * fov_rad);
  result.camera = {size.width, size.height, focal, focal, 0.5 * size.width, 0.5 * size.height};
  const Eigen::Matrix3d cam_from_world =
      CamFromWorld(Eigen::Vector3d::Zero(), direction).rotation.toRotationMatrix();

  // A point at (x, y, z) in the turned frame is inside for the camera centre c when
  // |x - cx| <= slope (z - cz): linear in c, so the nearest c that shows all is closed-form.
  Eigen::Vector2d upper(-kInfinity, -kInfinity), lower(-kInfinity, -kInfinity);
  double nearest_z = kInfinity, farthest_z = -kInfinity;
  const Eigen::Vector2d slope((0.5 - margin) * size.width / focal,
                              (0.5 - margin) * size.height / focal);
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d turned = cam_from_world * point;
    for (int k = 0; k < 2; ++k) {
      upper[k] = std::max(upper[k], turned[k] - slope[k] * turned.z());
      lower[k] = std::max(lower[k], -turned[k] - slope[k] * turned.z());
    }
    nearest_z = std::min(nearest_z, turned.z());
    farthest_z = std::max(farthest_z, turned.z());
  }
  Eigen::Vector3d center;
  center.head<2>() = 0.5 * (upper - lower);
  center.z() = (-0.5 * (upper + lower).array() / slope.array()).minCoeff();
  // A single point, or points along the view, leave the distance open.
  const double size_m = std::max(farthest_z - nearest_z, 1.0);
  center.z() = std::min(center.z(), nearest_z - 0.05 * size_m);
  result.cam_from_world.rotation = Eigen::Quaterniond(cam_from_world);
  result.cam_from_world.translation = -center;
  return result;
}

PictureCamera FitCamera(const BoundingBox& bounds, const ViewDirection& direction,
                        const cv::Size& size, double margin, double fov_rad) {
  return FitCamera(bounds.isEmpty() ? std::vector<Eigen::Vector3d>{} : CornersOf(bounds), direction,
                   size, margin, fov_rad);
}

std::vector<Eigen::Vector3d> CornersOf(const BoundingBox& box) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(box.corner(static_cast<BoundingBox::CornerType>(i)));
  }
  return corners;
}

BoundingBox RobustBounds(const std::vector<Eigen::Vector3d>& points, double tail) {
  BoundingBox box;
  if (points.empty()) return box;
  const auto skip =
      static_cast<std::ptrdiff_t>(std::floor(tail * static_cast<double>(points.size() - 1)));
  Eigen::Vector3d lowest, highest;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), values.begin(),
                   [axis](const Eigen::Vector3d& point) { return point[axis]; });
    std::nth_element(values.begin(), values.begin() + skip, values.end());
    lowest[axis] = values[static_cast<std::size_t>(skip)];
    std::nth_element(values.begin(), values.end() - 1 - skip, values.end());
    highest[axis] = *(values.end() - 1 - skip);
  }
  return {lowest, highest};
}

ColorAt ConstantColor(const Rgb& color) {
  return [color](const RayHit&, const Eigen::Vector3d&) { return color; };
}

ColorAt VertexColors(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& colors) {
  if (colors.size() != mesh.vertices.size()) {
    throw Error("picture: " + std::to_string(colors.size()) + " colours for " +
                std::to_string(mesh.vertices.size()) + " vertices");
  }
  return [&mesh, &colors](const RayHit& hit, const Eigen::Vector3d&) -> Rgb {
    const Eigen::Vector3i& face = mesh.faces[static_cast<std::size_t>(hit.face)];
    return ((1 - hit.u - hit.v) * colors[static_cast<std::size_t>(face[0])] +
            hit.u * colors[static_cast<std::size_t>(face[1])] +
            hit.v * colors[static_cast<std::size_t>(face[2])])
        .cast<float>();
  };
}

ColorAt FaceColors(const std::vector<Rgb>& colors) {
  return [&colors](const RayHit& hit, const Eigen::Vector3d&) {
    return colors[static_cast<std::size_t>(hit.face)];
  };
}

struct MeshPainter::Sample {
  Rgb color;
  double depth_m = kInfinity;
};

// Where the light comes from, chosen by the view so that every picture is well lit.
struct MeshPainter::Lights {
  Eigen::Vector3d eye_in_world;
  Eigen::Matrix3d world_from_cam;
  Eigen::Vector3d to_sun;  // unit
};

MeshPainter::MeshPainter(TriangleMesh mesh_in_world, const PictureOptions& options)
    : mesh_(std::move(mesh_in_world)),
      options_(options),
      scene_(mesh_),
      corner_normals_(CornerNormals(mesh_, options.crease_rad)) {
  if (!mesh_.vertices.empty()) size_m_ = BoundsOf(mesh_).diagonal().norm();
}

Rgb MeshPainter::Background(double share_from_top) const {
  const auto share = static_cast<float>(share_from_top);
  return (1 - share) * options_.background_top + share * options_.background_bottom;
}

Eigen::Vector3d MeshPainter::ShadingNormal(const RayHit& hit) const {
  const auto corner = 3 * static_cast<std::size_t>(hit.face);
  const Eigen::Vector3d normal = (1 - hit.u - hit.v) * corner_normals_[corner].cast<double>() +
                                 hit.u * corner_normals_[corner + 1].cast<double>() +
                                 hit.v * corner_normals_[corner + 2].cast<double>();
  return normal.normalized();
}

MeshPainter::Sample MeshPainter::Trace(const ColorAt& color, const PictureCamera& camera,
                                       const Lights& lights, const Eigen::Vector2d& pixel) const {
  Sample sample;
  const Eigen::Vector3d ray_in_cam = camera.camera.Ray(pixel);
  const double length = ray_in_cam.norm();
  const Eigen::Vector3d direction = lights.world_from_cam * (ray_in_cam / length);
  const auto hit = scene_.Intersect(lights.eye_in_world, direction, 0.0, 1e9);
  if (!hit) {
    sample.color = Background(pixel.y() / camera.camera.height);
    return sample;
  }
  sample.depth_m = hit->distance_m / length;
  const Eigen::Vector3d position = lights.eye_in_world + hit->distance_m * direction;
  Eigen::Vector3d normal = ShadingNormal(*hit);
  if (normal.dot(direction) > 0) normal = -normal;
  auto sun = static_cast<float>(std::max(0.0, normal.dot(lights.to_sun)));
  if (sun > 0 && options_.shadows) {
    const Eigen::Vector3d start = position + 1e-3 * size_m_ * normal;
    if (scene_.Intersect(start, lights.to_sun, 1e-3 * size_m_, 1e9)) sun *= kInShadow;
  }
  const float up = 0.5f + 0.5f * static_cast<float>(normal.z());
  sample.color = color(*hit, position) * (kSun * sun + up * kSky + (1 - up) * kGround);
  return sample;
}

MeshPainter::Lights MeshPainter::LightsFor(const PictureCamera& camera) {
  Lights lights;
  lights.eye_in_world = CameraCenter(camera.cam_from_world);
  lights.world_from_cam = camera.cam_from_world.rotation.toRotationMatrix().transpose();
  const ViewDirection view = ViewDirectionOf(camera.cam_from_world);
  // The sun stands behind the viewer's left shoulder.
  lights.to_sun = -DirectionInWorld({view.yaw_rad + DegToRad(50), DegToRad(-48)});
  return lights;
}

Picture MeshPainter::Render(const ColorAt& color, const PictureCamera& camera) const {
  const Lights lights = LightsFor(camera);
  Picture picture;
  picture.camera = camera;
  const int width = camera.camera.width, height = camera.camera.height;
  picture.depth_m.create(height, width, CV_32F);
  cv::Mat coarse(height, width, CV_32FC3);
  ParallelFor(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const Sample sample = Trace(color, camera, lights, {x + 0.5, y + 0.5});
      coarse.at<cv::Vec3f>(y, x) = {sample.color[0], sample.color[1], sample.color[2]};
      picture.depth_m.at<float>(y, x) = static_cast<float>(sample.depth_m);
    }
  });
  // Four samples only where neighbours differ: the same edges at a fraction of the rays.
  picture.bgr.create(height, width, CV_8UC3);
  ParallelFor(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f& center = coarse.at<cv::Vec3f>(y, x);
      Rgb mean(center[0], center[1], center[2]);
      if (LargestStep(coarse, y, x) > options_.supersample_contrast) {
        mean.setZero();
        for (const double dy : {0.25, 0.75}) {
          for (const double dx : {0.25, 0.75}) {
            mean += 0.25f * Trace(color, camera, lights, {x + dx, y + dy}).color;
          }
        }
      }
      picture.bgr.at<cv::Vec3b>(y, x) = ToBgr(mean);
    }
  });
  return picture;
}

Picture RenderMesh(const TriangleMesh& mesh, const ColorAt& color, const PictureCamera& camera,
                   const PictureOptions& options) {
  return MeshPainter(mesh, options).Render(color, camera);
}

void WritePng(const cv::Mat& bgr, const std::filesystem::path& path) {
  std::vector<std::uint8_t> bytes;
  if (bgr.empty() || !cv::imencode(".png", bgr, bytes)) {
    throw Error(path.string() + ": the picture cannot be encoded");
  }
  WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace colmap_ext
