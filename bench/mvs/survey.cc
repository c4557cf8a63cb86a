#include "survey.h"

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "colmap_ext/scene/position_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kPi = 3.14159265358979323846;
constexpr double kNoisePx = 0.4;
constexpr double kWrongShare = 0.01;
constexpr int kCornersPerPhoto = 130;
constexpr int kMatchedPhotos = 12;

struct View {
  Rigid3d cam_from_world;
  cv::Mat1f depth;
  std::vector<Eigen::Vector2d> corners_px;
};

PinholeCamera SurveyCamera(const SurveySpec& spec) {
  const double focal_px = 0.9 * spec.width;
  return {spec.width, spec.height, focal_px, focal_px, 0.5 * spec.width, 0.5 * spec.height};
}

std::vector<Eigen::Vector2d> FindCorners(const cv::Mat& bgr, int count) {
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(gray, found, count, 0.005, 8);
  std::vector<Eigen::Vector2d> corners_px;
  for (const cv::Point2f& p : found) corners_px.emplace_back(p.x + 0.5, p.y + 0.5);
  return corners_px;
}

// For each view the nearest others.
std::vector<std::vector<int>> MatchedViews(const std::vector<View>& views) {
  std::vector<std::vector<int>> matched(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<std::pair<double, int>> ranked;
    const Eigen::Vector3d center = CameraCenter(views[i].cam_from_world);
    for (std::size_t j = 0; j < views.size(); ++j) {
      const double distance = (CameraCenter(views[j].cam_from_world) - center).norm();
      if (j != i) ranked.emplace_back(distance, static_cast<int>(j));
    }
    std::sort(ranked.begin(), ranked.end());
    ranked.resize(std::min<std::size_t>(ranked.size(), kMatchedPhotos));
    for (const auto& entry : ranked) matched[i].push_back(entry.second);
  }
  return matched;
}

bool Sees(const View& view, const PinholeCamera& camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d in_cam = view.cam_from_world * point;
  if (!(in_cam.z() > 0) || !camera.Contains(camera.Project(in_cam), 4.0)) return false;
  const Eigen::Vector2d pixel = camera.Project(in_cam);
  const float depth = view.depth(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
  return depth > 0 && std::abs(in_cam.z() / static_cast<double>(depth) - 1.0) < 0.01;
}

struct Observation {
  int view;
  Eigen::Vector2d pixel;
};

// Linear triangulation: least squares over the observations' rays.
Eigen::Vector3d Triangulate(const std::vector<View>& views, const PinholeCamera& camera,
                            const std::vector<Observation>& observations) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Observation& o : observations) {
    const Rigid3d world_from_cam = Inverse(views[static_cast<std::size_t>(o.view)].cam_from_world);
    const Eigen::Vector3d ray = (world_from_cam.rotation * camera.Ray(o.pixel)).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * world_from_cam.translation;
  }
  return normal.ldlt().solve(right);
}

double MeanErrorPx(const std::vector<View>& views, const PinholeCamera& camera,
                   const std::vector<Observation>& observations, const Eigen::Vector3d& point) {
  double sum = 0;
  for (const Observation& o : observations) {
    const Eigen::Vector3d in_cam = views[static_cast<std::size_t>(o.view)].cam_from_world * point;
    sum += in_cam.z() > 0 ? (camera.Project(in_cam) - o.pixel).norm() : 1e3;
  }
  return sum / static_cast<double>(observations.size());
}

void AddPoint(const std::vector<View>& views, const PinholeCamera& camera,
              const std::vector<Observation>& observations, Reconstruction* model) {
  SparsePoint point;
  point.position = Triangulate(views, camera, observations);
  point.error_px = MeanErrorPx(views, camera, observations, point.position);
  if (!(point.error_px < 4.0)) return;  // as the mapper's filter
  const Point3DId id = model->points.size() + 1;
  for (const Observation& o : observations) {
    const auto image_id = static_cast<ImageId>(o.view + 1);
    std::vector<Keypoint2D>& keypoints = model->images.at(image_id).keypoints;
    point.track.push_back({image_id, static_cast<std::uint32_t>(keypoints.size())});
    keypoints.push_back({o.pixel, id});
  }
  model->points[id] = point;
}

void AddPoints(const std::vector<View>& views, const PinholeCamera& camera, Reconstruction* model) {
  std::mt19937_64 random(17);
  std::normal_distribution<double> noise(0, kNoisePx);
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::vector<std::vector<int>> matched = MatchedViews(views);
  const auto observe = [&](int view, const Eigen::Vector3d& point) {
    Eigen::Vector2d pixel =
        camera.Project(views[static_cast<std::size_t>(view)].cam_from_world * point);
    if (uniform(random) < kWrongShare) pixel += Eigen::Vector2d(12, 12) * uniform(random);
    return Observation{view, pixel + Eigen::Vector2d(noise(random), noise(random))};
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Rigid3d world_from_cam = Inverse(views[i].cam_from_world);
    for (const Eigen::Vector2d& corner : views[i].corners_px) {
      const float depth =
          views[i].depth(static_cast<int>(corner.y()), static_cast<int>(corner.x()));
      if (!(depth > 0)) continue;
      const Eigen::Vector3d truth =
          world_from_cam * (camera.Ray(corner) * static_cast<double>(depth));
      std::vector<Observation> observations{observe(static_cast<int>(i), truth)};
      for (const int j : matched[i]) {
        if (uniform(random) < 0.5 && Sees(views[static_cast<std::size_t>(j)], camera, truth)) {
          observations.push_back(observe(j, truth));
        }
      }
      if (observations.size() >= 2) AddPoint(views, camera, observations, model);
    }
  }
}

std::string PhotoName(std::size_t i) {
  char name[32];
  std::snprintf(name, sizeof name, "%05zu.jpg", i);
  return name;
}

}  // namespace

std::vector<Rigid3d> RingPoses(const Eigen::Vector3d& model_center,
                               const Eigen::Vector3d& model_size, int count) {
  const int rings = std::max(3, static_cast<int>(std::lround(std::sqrt(count / 9.0))));
  const double radius = 0.62 * model_size.head<2>().norm();
  std::vector<Rigid3d> poses;
  for (int i = 0; i < count; ++i) {
    const int ring = i % rings;
    const double share = (ring + 0.5) / rings;
    const double turn = 2 * kPi * (i + 0.37 * ring) / count;
    const double distance = radius * (1.55 - 0.35 * share);
    const Eigen::Vector3d target =
        model_center + Eigen::Vector3d(0, 0, (0.25 * share - 0.2) * model_size.z());
    const Eigen::Vector3d position =
        model_center + Eigen::Vector3d(distance * std::sin(turn), distance * std::cos(turn),
                                       model_size.z() * (1.1 * share - 0.25));
    const Eigen::Vector3d d = (target - position).normalized();
    poses.push_back(CamFromWorld(position, {std::atan2(d.x(), d.y()), std::asin(d.z())}));
  }
  return poses;
}

Survey PrepareSurvey(const SurveySpec& spec, const fs::path& folder, const JobControl& job) {
  const Survey survey{folder / "images", folder / "true_model", folder / "positions.txt"};
  if (fs::exists(survey.true_model / "points3D.bin")) return survey;
  fs::create_directories(survey.images);
  const TexturedScene scene = MakeScene(spec.scene, 1, spec.texel_scale);
  const TriangleMesh truth = scene.Truth().model;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : truth.vertices) box.extend(vertex);
  const std::vector<Rigid3d> poses = RingPoses(box.center(), box.sizes(), spec.photos);
  const PinholeCamera camera = SurveyCamera(spec);
  const Renderer renderer(scene, {});

  std::vector<View> views(poses.size());
  std::atomic<std::size_t> done = 0;
  ParallelFor(poses.size(), [&](std::size_t i) {
    job.ThrowIfCancelled();
    const cv::Mat bgr = renderer.Render(camera, poses[i]);
    cv::imwrite((survey.images / PhotoName(i)).string(), bgr, {cv::IMWRITE_JPEG_QUALITY, 95});
    views[i] = {poses[i], renderer.RenderDepth(camera, poses[i]),
                FindCorners(bgr, kCornersPerPhoto)};
    job.Progress("rendering", ++done, poses.size());
  });
  Reconstruction model;
  model.cameras[1] = ToCamera(camera);
  std::map<std::string, Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    model.images[static_cast<ImageId>(i + 1)] = {PhotoName(i), 1, poses[i], {}};
    positions[PhotoName(i)] = CameraCenter(poses[i]);
  }
  AddPoints(views, camera, &model);
  WritePosePriorFile(positions, survey.positions);
  WriteReconstructionBinary(model, survey.true_model);
  return survey;
}

fs::path PrepareRealSfm(const Survey& survey, const fs::path& folder, const JobControl& job) {
  const fs::path path = folder / "sfm_model";
  if (fs::exists(path / "points3D.bin")) return path;
  SparseUpdateInput input;
  input.image_path = survey.images;
  input.database_path = folder / "sfm.db";
  input.work_path = folder / "sfm_logs";
  input.camera = ReadReconstruction(survey.true_model).cameras.begin()->second;
  input.local_position_of_photo = ReadPosePriorFile(survey.positions);
  WriteReconstructionBinary(UpdateSparseModel(input, {}, job).model, path);
  return path;
}

}  // namespace colmap_ext
