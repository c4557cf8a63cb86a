#include "bundle_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

void CheckPrior(const PhotoPrior& prior, const std::string& name) {
  if (prior.position_in_world) {
    if (!prior.position_in_world->allFinite()) {
      throw Error(name + ": its measured position is not finite");
    }
    if (!(prior.sigma_horizontal_m > 0 && prior.sigma_vertical_m > 0)) {
      throw Error(name + ": the sigmas of its measured position must be above 0 m");
    }
  }
  if (!prior.up_in_cam) return;
  if (!(std::abs(prior.up_in_cam->norm() - 1) < 1e-6)) {
    throw Error(name + ": its measured vertical is not of unit length");
  }
  if (!(prior.up_sigma_rad > 0)) throw Error(name + ": the sigma of its vertical must be above 0");
}

void CheckCamera(CameraId id, const Camera& camera) {
  const std::string where = "camera " + std::to_string(id);
  const CameraModelInfo& info = GetCameraModelInfo(static_cast<int>(camera.model));
  if (camera.params.size() != static_cast<std::size_t>(info.num_params)) {
    throw Error(where + ": " + info.name + " has " + std::to_string(info.num_params) +
                " parameters, not " + std::to_string(camera.params.size()));
  }
  bool is_fine = camera.width > 0 && camera.height > 0;
  for (const double param : camera.params) is_fine = is_fine && std::isfinite(param);
  for (int k = 0; k < NumFocalParams(camera.model); ++k) {
    is_fine = is_fine && camera.params[static_cast<std::size_t>(k)] > 0;
  }
  if (!is_fine) {
    throw Error(where +
                ": its size and focal length must be above 0 and all parameters finite; give "
                "intrinsics that are known, or map again");
  }
}

// Collects the parts in id order.
class Gatherer {
 public:
  Gatherer(const BundleSelection& selection, const BundleOptions& options,
           const std::vector<CameraId>& locked_cameras, const Reconstruction& model)
      : selection_(selection), options_(options), locked_(locked_cameras), model_(model) {}

  BundleState Run() {
    CollectFreeImages();
    CollectPoints();
    CollectPoses();
    CollectObservations();
    return std::move(state_);
  }

 private:
  void CollectFreeImages() {
    if (!selection_.free_images) {
      for (const auto& [id, image] : model_.images) free_images_.push_back(id);
      return;
    }
    for (const ImageId id : *selection_.free_images) {
      if (model_.images.count(id) == 0) {
        throw Error("photo " + std::to_string(id) + " to be adjusted is not in the model");
      }
      free_images_.push_back(id);
    }
  }

  void CollectPoints() {
    std::vector<Point3DId> ids;
    for (const ImageId image_id : free_images_) {
      for (const Keypoint2D& keypoint : model_.images.at(image_id).keypoints) {
        if (keypoint.point3D_id != kInvalidPoint3DId) ids.push_back(keypoint.point3D_id);
      }
    }
    if (selection_.free_points) {
      ids.insert(ids.end(), selection_.free_points->begin(), selection_.free_points->end());
    }
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    state_.points.reserve(ids.size());
    for (const Point3DId id : ids) {
      const auto found = model_.points.find(id);
      if (found == model_.points.end()) {
        throw Error("point " + std::to_string(id) + " to be adjusted is not in the model");
      }
      sparse_points_.push_back(&found->second);
      BundlePoint point;
      point.id = id;
      point.is_free = !selection_.free_points || selection_.free_points->count(id) > 0;
      point.position = found->second.position;
      state_.points.push_back(point);
    }
  }

  bool IsFreeImage(ImageId id) const {
    return std::binary_search(free_images_.begin(), free_images_.end(), id);
  }

  // Free photos and those that see free points.
  void CollectPoses() {
    std::vector<ImageId> ids = free_images_;
    for (std::size_t p = 0; p < state_.points.size(); ++p) {
      if (!state_.points[p].is_free) continue;
      for (const TrackElement& element : sparse_points_[p]->track) ids.push_back(element.image_id);
    }
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    for (const ImageId id : ids) {
      const SparseImage& image = model_.images.at(id);
      images_.push_back(&image);
      pose_of_image_[id] = state_.poses.size();
      BundlePose pose;
      pose.image_id = id;
      pose.is_free = IsFreeImage(id);
      pose.SetCamFromWorld(image.cam_from_world);
      const auto prior = selection_.prior_of_image.find(id);
      if (pose.is_free && prior != selection_.prior_of_image.end()) {
        CheckPrior(prior->second, image.name);
        pose.prior = &prior->second;
      }
      pose.camera = CameraIndex(image.camera_id);
      if (pose.is_free) FreeIntrinsics(&state_.cameras[pose.camera]);
      state_.poses.push_back(pose);
    }
  }

  std::size_t CameraIndex(CameraId id) {
    const auto [entry, is_new] = camera_index_.emplace(id, state_.cameras.size());
    if (is_new) {
      BundleCamera camera;
      camera.camera_id = id;
      camera.camera = model_.cameras.at(id);
      CheckCamera(id, camera.camera);
      state_.cameras.push_back(camera);
    }
    return entry->second;
  }

  void FreeIntrinsics(BundleCamera* camera) const {
    if (!camera->free_params.empty()) return;
    if (std::find(locked_.begin(), locked_.end(), camera->camera_id) != locked_.end()) return;
    const int num_focal = NumFocalParams(camera->camera.model);
    const int num_params = static_cast<int>(camera->camera.params.size());
    for (int k = 0; k < num_params; ++k) {
      const bool is_free = k < num_focal       ? options_.refine_focal_length
                           : k < num_focal + 2 ? options_.refine_principal_point
                                               : options_.refine_extra_params;
      if (!is_free) continue;
      camera->free_values[camera->free_params.size()] =
          camera->camera.params[static_cast<std::size_t>(k)];
      camera->free_params.push_back(k);
    }
  }

  void CollectObservations() {
    for (std::size_t p = 0; p < state_.points.size(); ++p) {
      BundlePoint& point = state_.points[p];
      point.first_observation = state_.observations.size();
      for (const TrackElement& element : sparse_points_[p]->track) {
        if (!point.is_free && !IsFreeImage(element.image_id)) continue;
        BundleObservation observation;
        observation.pose = pose_of_image_.at(element.image_id);
        observation.point = p;
        observation.keypoint_index = element.keypoint_index;
        observation.pixel = images_[observation.pose]->keypoints[element.keypoint_index].pixel;
        state_.observations.push_back(observation);
      }
      point.num_observations = state_.observations.size() - point.first_observation;
    }
  }

  const BundleSelection& selection_;
  const BundleOptions& options_;
  const std::vector<CameraId>& locked_;
  const Reconstruction& model_;
  std::vector<ImageId> free_images_;               // sorted
  std::vector<const SparsePoint*> sparse_points_;  // of state_.points
  std::vector<const SparseImage*> images_;         // of state_.poses
  std::map<ImageId, std::size_t> pose_of_image_;   // index
  std::map<CameraId, std::size_t> camera_index_;
  BundleState state_;
};

// Whether two of the rays from the living observations meet at the wanted angle or more.
bool HasAngle(const BundleState& state, const BundlePoint& point, double max_cosine) {
  const std::size_t end = point.first_observation + point.num_observations;
  for (std::size_t i = point.first_observation; i < end; ++i) {
    if (!state.observations[i].is_alive) continue;
    const Eigen::Vector3d ray_i =
        (point.position - state.poses[state.observations[i].pose].center()).normalized();
    for (std::size_t j = i + 1; j < end; ++j) {
      if (!state.observations[j].is_alive) continue;
      const Eigen::Vector3d ray_j =
          (point.position - state.poses[state.observations[j].pose].center()).normalized();
      // As COLMAP: rays that open by more than a right angle count by their supplement.
      if (std::abs(ray_i.dot(ray_j)) <= max_cosine) return true;
    }
  }
  return false;
}

void EraseObservation(const BundleState& state, const BundleObservation& observation,
                      Reconstruction* model) {
  const ImageId image_id = state.poses[observation.pose].image_id;
  model->images.at(image_id).keypoints[observation.keypoint_index].point3D_id = kInvalidPoint3DId;
}

void ErasePoint(const BundlePoint& point, Reconstruction* model) {
  for (const TrackElement& element : model->points.at(point.id).track) {
    model->images.at(element.image_id).keypoints[element.keypoint_index].point3D_id =
        kInvalidPoint3DId;
  }
  model->points.erase(point.id);
}

// Drops dead observations from the track and from the photos.
void ShortenTrack(const BundleState& state, const BundlePoint& point, Reconstruction* model) {
  std::vector<TrackElement>& track = model->points.at(point.id).track;
  for (std::size_t k = 0; k < point.num_observations; ++k) {
    const BundleObservation& observation = state.observations[point.first_observation + k];
    if (observation.is_alive) continue;
    EraseObservation(state, observation, model);
    const ImageId image_id = state.poses[observation.pose].image_id;
    std::erase_if(track, [&](const TrackElement& element) {
      return element.image_id == image_id && element.keypoint_index == observation.keypoint_index;
    });
  }
}

// Over the whole track, also the part that the state does not have.
double MeanErrorPx(const SparsePoint& point, const Reconstruction& model) {
  double sum = 0;
  for (const TrackElement& element : point.track) {
    const SparseImage& image = model.images.at(element.image_id);
    const Eigen::Vector3d in_cam = image.cam_from_world * point.position;
    const Eigen::Vector2d pixel =
        ImageFromNormalized(model.cameras.at(image.camera_id), in_cam.hnormalized());
    sum += (pixel - image.keypoints[element.keypoint_index].pixel).norm();
  }
  return sum / static_cast<double>(point.track.size());
}

// The same for a free point, whose whole track the state has.
double MeanErrorPx(const BundleState& state, const BundlePoint& point) {
  double sum = 0;
  int num_alive = 0;
  for (std::size_t k = 0; k < point.num_observations; ++k) {
    const BundleObservation& observation = state.observations[point.first_observation + k];
    if (!observation.is_alive) continue;
    sum += state.ErrorPx(observation);
    ++num_alive;
  }
  return sum / num_alive;
}

}  // namespace

Rigid3d BundlePose::CamFromWorld() const {
  const Eigen::Vector3d turn(turn_and_center[0], turn_and_center[1], turn_and_center[2]);
  Rigid3d cam_from_world;
  cam_from_world.rotation =
      turn.isZero(0) ? rotation_base
                     : (Eigen::AngleAxisd(turn.norm(), turn.normalized()) * rotation_base);
  cam_from_world.rotation.normalize();
  cam_from_world.translation = -(cam_from_world.rotation * Eigen::Vector3d(center()));
  return cam_from_world;
}

void BundlePose::SetCamFromWorld(const Rigid3d& cam_from_world) {
  rotation_base = cam_from_world.rotation.normalized();
  std::fill_n(turn_and_center, 3, 0.0);
  Eigen::Map<Eigen::Vector3d>(turn_and_center + 3) = CameraCenter(cam_from_world);
  Refresh();
}

void BundlePose::Refresh() {
  const Eigen::Vector3d turn(turn_and_center[0], turn_and_center[1], turn_and_center[2]);
  const double angle = turn.norm();
  if (angle < 1e-9) {  // exp(turn) = 1 + [turn]x to the last bit
    Eigen::Matrix3d cross;
    cross << 0, -turn.z(), turn.y(), turn.z(), 0, -turn.x(), -turn.y(), turn.x(), 0;
    rotation = (Eigen::Matrix3d::Identity() + cross) * rotation_base.toRotationMatrix();
    turn_jacobian = Eigen::Matrix3d::Identity() + 0.5 * cross;
    return;
  }
  const Eigen::Vector3d axis = turn / angle;
  rotation = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * rotation_base.toRotationMatrix();
  Eigen::Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double sinc = std::sin(angle) / angle;
  const double half_sin = std::sin(0.5 * angle);
  turn_jacobian = sinc * Eigen::Matrix3d::Identity() + (1 - sinc) * axis * axis.transpose() +
                  (2 * half_sin * half_sin / angle) * cross;
}

void BundleCamera::Refresh() {
  for (std::size_t k = 0; k < free_params.size(); ++k) {
    camera.params[static_cast<std::size_t>(free_params[k])] = free_values[k];
  }
}

Eigen::Vector3d BundleState::PointInCam(const BundleObservation& observation) const {
  const BundlePose& pose = poses[observation.pose];
  return pose.rotation * (points[observation.point].position - pose.center());
}

double BundleState::ErrorPx(const BundleObservation& observation) const {
  const Eigen::Vector3d point_in_cam = PointInCam(observation);
  if (!(point_in_cam.z() > 0)) return std::numeric_limits<double>::infinity();
  const Camera& camera = cameras[poses[observation.pose].camera].camera;
  const double error =
      (ImageFromNormalized(camera, point_in_cam.hnormalized()) - observation.pixel).norm();
  return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

BundleState GatherBundle(const BundleSelection& selection, const BundleOptions& options,
                         const std::vector<CameraId>& locked_cameras, const Reconstruction& model) {
  return Gatherer(selection, options, locked_cameras, model).Run();
}

FilterCounts FilterBundle(const BundleOptions& options, BundleState* state) {
  const double max_cosine = std::cos(DegToRad(options.filter_min_angle_deg));
  FilterCounts counts;
  for (BundlePoint& point : state->points) {
    if (!point.is_alive) continue;
    std::size_t num_alive = 0;
    for (std::size_t k = 0; k < point.num_observations; ++k) {
      BundleObservation& observation = state->observations[point.first_observation + k];
      if (!observation.is_alive) continue;
      observation.is_alive = state->ErrorPx(observation) <= options.filter_max_error_px;
      observation.is_alive ? ++num_alive : ++counts.observations;
    }
    // What else sees a fixed point is not known here, so it is never judged as a whole.
    if (!point.is_free) continue;
    point.is_alive = num_alive >= 2 && HasAngle(*state, point, max_cosine);
    if (point.is_alive) continue;
    ++counts.points;
    counts.observations += num_alive;
  }
  return counts;
}

void ApplyBundle(const BundleState& state, Reconstruction* model) {
  for (const BundlePose& pose : state.poses) {
    if (pose.is_free) model->images.at(pose.image_id).cam_from_world = pose.CamFromWorld();
  }
  for (const BundleCamera& camera : state.cameras) {
    if (!camera.free_params.empty()) model->cameras.at(camera.camera_id) = camera.camera;
  }
  for (const BundlePoint& point : state.points) {
    if (!point.is_alive) {
      ErasePoint(point, model);
      continue;
    }
    ShortenTrack(state, point, model);
    SparsePoint& sparse_point = model->points.at(point.id);
    if (sparse_point.track.size() < 2) {
      ErasePoint(point, model);
      continue;
    }
    if (point.is_free) sparse_point.position = point.position;
    sparse_point.error_px =
        point.is_free ? MeanErrorPx(state, point) : MeanErrorPx(sparse_point, *model);
  }
}

}  // namespace colmap_ext
