#include "colmap_ext/report/picture_overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "report/blend.h"

namespace colmap_ext {
namespace {

// Lines on a surface must not drown in it: a share of the depth by which they may lie behind.
constexpr double kDepthBias = 0.004;

// A point of a line in the picture: pixel and inverse depth (which is linear along the line there).
struct LinePoint {
  Eigen::Vector2d pixel;
  double inverse_depth = 0;
};

// Cuts off what lies behind the camera. Returns false when nothing is left.
bool ClipAndProject(const PictureCamera& camera, const Eigen::Vector3d& a_in_world,
                    const Eigen::Vector3d& b_in_world, LinePoint* a, LinePoint* b) {
  Eigen::Vector3d first = camera.cam_from_world * a_in_world;
  Eigen::Vector3d second = camera.cam_from_world * b_in_world;
  constexpr double kNear = 1e-3;
  if (first.z() < kNear && second.z() < kNear) return false;
  if (first.z() < kNear) {
    first += (second - first) * ((kNear - first.z()) / (second.z() - first.z()));
  } else if (second.z() < kNear) {
    second += (first - second) * ((kNear - second.z()) / (first.z() - second.z()));
  }
  *a = {camera.camera.Project(first), 1.0 / first.z()};
  *b = {camera.camera.Project(second), 1.0 / second.z()};
  return true;
}

// Shrinks a segment to a box around the picture, so that its pixels can be enumerated.
bool ClipToPicture(const cv::Size& size, double margin, LinePoint* a, LinePoint* b) {
  double begin = 0, end = 1;
  const Eigen::Vector2d step = b->pixel - a->pixel;
  const std::array<double, 2> limit = {size.width + margin, size.height + margin};
  for (int k = 0; k < 2; ++k) {
    if (step[k] == 0) {
      if (a->pixel[k] < -margin || a->pixel[k] > limit[static_cast<std::size_t>(k)]) return false;
      continue;
    }
    double enter = (-margin - a->pixel[k]) / step[k];
    double leave = (limit[static_cast<std::size_t>(k)] - a->pixel[k]) / step[k];
    if (enter > leave) std::swap(enter, leave);
    begin = std::max(begin, enter);
    end = std::min(end, leave);
  }
  if (begin >= end) return false;
  const LinePoint from = *a, to = *b;
  const auto at = [&](double t) {
    return LinePoint{from.pixel + t * step, (1 - t) * from.inverse_depth + t * to.inverse_depth};
  };
  *a = at(begin);
  *b = at(end);
  return true;
}

// Coverage of many segments, the strongest one where several meet.
class StrokeMask {
 public:
  StrokeMask(const Picture& picture, double width_px, double hidden_opacity)
      : picture_(picture),
        half_width_(0.5 * width_px),
        hidden_opacity_(hidden_opacity),
        mask_(picture.bgr.rows, picture.bgr.cols, CV_32F, cv::Scalar(0)) {}

  void Add(LinePoint a, LinePoint b) {
    const double reach = half_width_ + 1;
    if (!ClipToPicture(mask_.size(), reach, &a, &b)) return;
    // Short pieces keep the visited box small.
    const double length = (b.pixel - a.pixel).norm();
    const int pieces = std::max(1, static_cast<int>(length / 16));
    for (int i = 0; i < pieces; ++i) {
      AddPiece(Between(a, b, static_cast<double>(i) / pieces),
               Between(a, b, static_cast<double>(i + 1) / pieces));
    }
  }

  const cv::Mat& mask() const { return mask_; }

 private:
  static LinePoint Between(const LinePoint& a, const LinePoint& b, double t) {
    return {(1 - t) * a.pixel + t * b.pixel, (1 - t) * a.inverse_depth + t * b.inverse_depth};
  }

  void AddPiece(const LinePoint& a, const LinePoint& b) {
    const double reach = half_width_ + 1;
    const Eigen::Vector2d step = b.pixel - a.pixel;
    const double length2 = step.squaredNorm();
    const Eigen::Vector2d low = a.pixel.cwiseMin(b.pixel).array() - reach;
    const Eigen::Vector2d high = a.pixel.cwiseMax(b.pixel).array() + reach;
    const int x_end = std::min(static_cast<int>(std::ceil(high.x())), mask_.cols);
    const int y_end = std::min(static_cast<int>(std::ceil(high.y())), mask_.rows);
    for (int y = std::max(0, static_cast<int>(low.y())); y < y_end; ++y) {
      for (int x = std::max(0, static_cast<int>(low.x())); x < x_end; ++x) {
        const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
        const double t =
            length2 > 0 ? std::clamp((pixel - a.pixel).dot(step) / length2, 0.0, 1.0) : 0.0;
        const double distance = (a.pixel + t * step - pixel).norm();
        double coverage = std::clamp(half_width_ + 0.5 - distance, 0.0, 1.0);
        if (coverage <= 0) continue;
        const double depth = 1.0 / ((1 - t) * a.inverse_depth + t * b.inverse_depth);
        if (depth * (1 - kDepthBias) > picture_.depth_m.at<float>(y, x)) {
          coverage *= hidden_opacity_;
        }
        float& mask = mask_.at<float>(y, x);
        mask = std::max(mask, static_cast<float>(coverage));
      }
    }
  }

  const Picture& picture_;
  double half_width_;
  double hidden_opacity_;
  cv::Mat mask_;
};

cv::Mat MaskOf(const std::vector<Polyline3d>& lines, double width_px, double hidden_opacity,
               const Picture& picture) {
  StrokeMask stroke(picture, width_px, hidden_opacity);
  for (const Polyline3d& line : lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      LinePoint a, b;
      if (ClipAndProject(picture.camera, line[i], line[i + 1], &a, &b)) stroke.Add(a, b);
    }
  }
  return stroke.mask();
}

}  // namespace

std::optional<Eigen::Vector2d> ProjectToPicture(const PictureCamera& camera,
                                                const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d point_in_cam = camera.cam_from_world * point_in_world;
  if (point_in_cam.z() < 1e-3) return std::nullopt;
  return camera.camera.Project(point_in_cam);
}

void DrawPolylines(const std::vector<Polyline3d>& lines, const StrokeStyle& style,
                   Picture* picture) {
  if (style.halo_px > 0) {
    BlendColor(MaskOf(lines, style.width_px + 2 * style.halo_px, 0, *picture), {1, 1, 1},
               0.85 * style.opacity, &picture->bgr);
  }
  BlendColor(MaskOf(lines, style.width_px, style.hidden_opacity, *picture), style.color,
             style.opacity, &picture->bgr);
}

std::vector<Polyline3d> FrustumLines(const PinholeCamera& camera, const Rigid3d& cam_from_world,
                                     double depth_m) {
  const Rigid3d world_from_cam = Inverse(cam_from_world);
  const auto corner = [&](double u, double v) {
    return world_from_cam * (depth_m * camera.Ray({u * camera.width, v * camera.height}));
  };
  const Eigen::Vector3d center = world_from_cam.translation;
  const Polyline3d outline = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1), corner(0, 0)};
  std::vector<Polyline3d> lines = {outline};
  for (int i = 0; i < 4; ++i) lines.push_back({center, outline[static_cast<std::size_t>(i)]});
  lines.push_back({corner(0.35, 0), corner(0.5, -0.2), corner(0.65, 0)});
  return lines;
}

void FillPolygon(const Polyline3d& outline, const Rgb& color, double opacity, Picture* picture) {
  constexpr int kShift = 4;
  std::vector<cv::Point> pixels;
  double depth_sum = 0;
  for (const Eigen::Vector3d& point : outline) {
    const auto pixel = ProjectToPicture(picture->camera, point);
    if (!pixel) return;
    if (pixel->cwiseAbs().maxCoeff() > 20000)
      return;  // far outside, and fixed point would overflow
    // cv counts from the centre of the first pixel.
    pixels.emplace_back(static_cast<int>(std::lround((pixel->x() - 0.5) * (1 << kShift))),
                        static_cast<int>(std::lround((pixel->y() - 0.5) * (1 << kShift))));
    depth_sum += (picture->camera.cam_from_world * point).z();
  }
  if (pixels.size() < 3) return;
  cv::Mat filled(picture->bgr.size(), CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(filled, pixels, cv::Scalar(255), cv::LINE_AA, kShift);
  const double depth = depth_sum / static_cast<double>(pixels.size()) * (1 - kDepthBias);
  filled.setTo(cv::Scalar(0), picture->depth_m < depth);
  cv::Mat mask;
  filled.convertTo(mask, CV_32F, 1.0 / 255);
  BlendColor(mask, color, opacity, &picture->bgr);
}

void DrawDiscs(const std::vector<Eigen::Vector3d>& points,
               const std::vector<Eigen::Vector3d>& normals, const std::vector<Rgb>& colors,
               double radius_m, Picture* picture) {
  const PinholeCamera& camera = picture->camera.camera;
  const Eigen::Matrix3d rotation = picture->camera.cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d up = rotation * Eigen::Vector3d::UnitZ();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d center = picture->camera.cam_from_world * points[i];
    if (center.z() < 1e-3) continue;
    const Eigen::Vector3d normal = rotation * normals[i];
    const Eigen::Vector2d middle = camera.Project(center);
    const double reach = camera.fx * radius_m / center.z() + 1;
    const int x_end = std::min(camera.width, static_cast<int>(std::ceil(middle.x() + reach)));
    const int y_end = std::min(camera.height, static_cast<int>(std::ceil(middle.y() + reach)));
    const auto light = static_cast<float>(0.72 + 0.18 * normal.dot(up) +
                                          0.10 * std::abs(normal.dot(center.normalized())));
    const Rgb shaded = (colors[i] * light * 255.0f).cwiseMin(255.0f).cwiseMax(0.0f);
    const cv::Vec3b bgr(static_cast<std::uint8_t>(shaded[2]), static_cast<std::uint8_t>(shaded[1]),
                        static_cast<std::uint8_t>(shaded[0]));
    for (int y = std::max(0, static_cast<int>(middle.y() - reach)); y < y_end; ++y) {
      for (int x = std::max(0, static_cast<int>(middle.x() - reach)); x < x_end; ++x) {
        const Eigen::Vector3d ray = camera.Ray({x + 0.5, y + 0.5});
        const double slant = normal.dot(ray);
        if (std::abs(slant) < 1e-6) continue;
        const double depth = normal.dot(center) / slant;
        if (!(depth > 0) || (depth * ray - center).squaredNorm() > radius_m * radius_m) continue;
        float& nearest = picture->depth_m.at<float>(y, x);
        if (depth * (1 - kDepthBias) > nearest) continue;
        nearest = std::min(nearest, static_cast<float>(depth));
        picture->bgr.at<cv::Vec3b>(y, x) = bgr;
      }
    }
  }
}

}  // namespace colmap_ext
