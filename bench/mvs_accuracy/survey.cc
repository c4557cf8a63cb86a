#include "survey.h"

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/sim/renderer.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/sim/textured_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kTwoPi = 6.283185307179586;

// Three rings around the scene, higher and steeper from one to the next; indoors inside the room.
std::vector<PlannedView> Rings(const std::string& scene, int num_photos) {
  std::vector<PlannedView> views;
  const bool indoor = scene == "boxes";
  for (int i = 0; i < num_photos; ++i) {
    const int ring = 3 * i / num_photos;
    const int first = (ring * num_photos + 2) / 3;
    const int size = ((ring + 1) * num_photos + 2) / 3 - first;
    const double angle = kTwoPi * (i - first + 0.33 * ring) / size;
    const double radius = indoor ? 2.4 : 30.0 - 3.0 * ring;
    const double height = indoor ? 1.4 + 0.5 * ring : 14.0 + 5.0 * ring;
    PlannedView view;
    view.id = i;
    view.position = {radius * std::sin(angle), radius * std::cos(angle), height};
    const double pitch_deg = indoor ? -20.0 - 10.0 * ring : -15.0 - 9.0 * ring;
    view.direction = {NormalizeAngle(angle + 0.5 * kTwoPi), DegToRad(pitch_deg)};
    views.push_back(view);
  }
  return views;
}

std::string PhotoName(std::size_t i) {
  const std::string digits = std::to_string(i);
  return "photo_" + std::string(4 - std::min<std::size_t>(4, digits.size()), '0') + digits + ".jpg";
}

void RenderAll(const SurveyOptions& options, const fs::path& folder, const JobControl& job) {
  const TexturedScene scene = MakeScene(options.scene, 1, options.texel_scale);
  const Renderer renderer(scene, RenderOptions{});
  const SimulatedCamera camera(renderer, scene.origin, SimulatedCameraOptions{});
  const std::vector<PlannedView> views = Rings(options.scene, options.num_photos);
  std::vector<TruePose> poses(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    const std::string name = PhotoName(i);
    const CapturedPhoto photo = camera.CapturePhoto(views[i], folder / "images" / name);
    poses[i] = {name, photo.cam_from_world};
    const cv::Mat1f depth = renderer.RenderDepth(photo.camera, photo.cam_from_world);
    const cv::Mat1i faces = renderer.RenderFaces(photo.camera, photo.cam_from_world);
    DenseMap map(depth.cols, depth.rows, 2);
    for (int y = 0; y < depth.rows; ++y) {
      for (int x = 0; x < depth.cols; ++x) {
        const int face = faces(y, x);
        map.At(y, x, 0) = depth(y, x);
        map.At(y, x, 1) =
            face >= 0 && !scene.IsGround(static_cast<std::size_t>(face)) ? 1.0F : 0.0F;
      }
    }
    WriteDenseMap(map, folder / "truth" / (name + ".bin"));
    job.Progress("rendering", i, views.size());
  });
  WriteTruePoses(poses, folder / "true_poses.txt");
}

void Map(const SurveyOptions& options, const std::vector<TruePose>& poses, const fs::path& folder,
         const JobControl& job) {
  SparseUpdateInput input;
  input.colmap_path = options.colmap_path;
  input.image_path = folder / "images";
  input.database_path = folder / "database.db";
  input.work_path = folder / "sfm_work";
  input.camera = ToCamera(SimulatedCameraOptions{}.LowCamera());
  for (const TruePose& pose : poses) {
    input.local_position_of_photo[pose.name] = CameraCenter(pose.cam_from_world);
  }
  const SparseUpdateResult result = UpdateSparseModel(input, SparseUpdateOptions{}, job);
  WriteReconstructionText(result.model, folder / "sparse.tmp");
  fs::rename(folder / "sparse.tmp", folder / "sparse");
}

// Similarity of the camera centres.
Sim3d TruthFromModel(const Reconstruction& model, const std::map<std::string, Rigid3d>& pose_of) {
  Eigen::Matrix3Xd src(3, static_cast<Eigen::Index>(model.images.size()));
  Eigen::Matrix3Xd dst(3, src.cols());
  Eigen::Index column = 0;
  for (const auto& [id, image] : model.images) {
    src.col(column) = CameraCenter(image.cam_from_world);
    dst.col(column++) = CameraCenter(pose_of.at(image.name));
  }
  return EstimateSimilarity(src, dst);
}

// The point nearest to the rays of a track, and its mean reprojection error; false when some ray
// disagrees by more than kMaxErrorPx.
bool Triangulate(const Reconstruction& model, SparsePoint* point) {
  constexpr double kMaxErrorPx = 4.0;
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const TrackElement& element : point->track) {
    const SparseImage& image = model.images.at(element.image_id);
    const PinholeCamera camera = ToPinhole(model.cameras.at(image.camera_id));
    const Eigen::Vector3d ray = (image.cam_from_world.rotation.conjugate() *
                                 camera.Ray(image.keypoints[element.keypoint_index].pixel))
                                    .normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal_matrix += across;
    right_side += across * CameraCenter(image.cam_from_world);
  }
  point->position = normal_matrix.ldlt().solve(right_side);
  point->error_px = 0;
  for (const TrackElement& element : point->track) {
    const SparseImage& image = model.images.at(element.image_id);
    const Eigen::Vector3d in_cam = image.cam_from_world * point->position;
    if (!(in_cam.z() > 0)) return false;
    const double error = (ToPinhole(model.cameras.at(image.camera_id)).Project(in_cam) -
                          image.keypoints[element.keypoint_index].pixel)
                             .norm();
    if (!(error < kMaxErrorPx)) return false;
    point->error_px += error / static_cast<double>(point->track.size());
  }
  return true;
}

void TakeTruePoses(const std::map<std::string, Rigid3d>& pose_of, Reconstruction* model) {
  for (auto& [id, image] : model->images) image.cam_from_world = pose_of.at(image.name);
  for (auto it = model->points.begin(); it != model->points.end();) {
    if (Triangulate(*model, &it->second)) {
      ++it;
      continue;
    }
    for (const TrackElement& element : it->second.track) {
      model->images.at(element.image_id).keypoints[element.keypoint_index].point3D_id =
          kInvalidPoint3DId;
    }
    it = model->points.erase(it);
  }
}

ViewTruth ReadTruth(const fs::path& path) {
  const DenseMap map = ReadDenseMap(path);
  ViewTruth truth{cv::Mat1f(map.height, map.width), cv::Mat1b(map.height, map.width)};
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      truth.depth(y, x) = map.At(y, x, 0);
      truth.model(y, x) = map.At(y, x, 1) > 0.5F;
    }
  }
  return truth;
}

}  // namespace

Survey MakeSurvey(const SurveyOptions& options, const JobControl& job) {
  const fs::path folder =
      options.cache / (options.scene + "_" + std::to_string(options.num_photos) + "_" +
                       std::to_string(std::lround(100 * options.texel_scale)));
  if (!fs::exists(folder / "true_poses.txt")) RenderAll(options, folder, job);
  const std::vector<TruePose> poses = ReadTruePoses(folder / "true_poses.txt");
  if (!fs::exists(folder / "sparse")) Map(options, poses, folder, job);

  std::map<std::string, Rigid3d> pose_of;
  for (const TruePose& pose : poses) pose_of[pose.name] = pose.cam_from_world;
  Reconstruction model = ReadReconstruction(folder / "sparse");
  if (options.sfm_poses) {
    TransformReconstruction(TruthFromModel(model, pose_of), &model);
  } else {
    TakeTruePoses(pose_of, &model);
  }
  Survey survey;
  survey.photos = LoadPhotoSet(model, (folder / "images").string(), true);
  for (const PosedPhoto& photo : survey.photos.photos) {
    survey.truth.push_back(ReadTruth(folder / "truth" / (photo.name + ".bin")));
  }
  return survey;
}

}  // namespace colmap_ext
