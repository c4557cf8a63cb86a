#include "colmap_ext/scene/reconstruction.h"

#include <cmath>
#include <set>
#include <unordered_map>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Collects where we are, so that each complaint is one call.
class Checker {
 public:
  Checker(const Reconstruction& model, const std::string& where) : model_(model), where_(where) {}

  void Run() {
    for (const auto& [id, camera] : model_.cameras) CheckCamera(id, camera);
    std::set<std::string> names;
    for (const auto& [id, image] : model_.images) {
      CheckImage(id, image);
      if (!names.insert(image.name).second) {
        Fail("two images have the name '" + image.name + "'");
      }
    }
    for (const auto& [id, point] : model_.points) CheckPoint(id, point);
    CheckFrames();
  }

 private:
  [[noreturn]] void Fail(const std::string& problem) const {
    throw Error(where_ + ": " + problem + "; the model is corrupt, write it again");
  }

  void CheckCamera(CameraId id, const Camera& camera) const {
    const std::string name = "camera " + std::to_string(id);
    const CameraModelInfo& info = GetCameraModelInfo(static_cast<int>(camera.model));
    if (camera.width <= 0 || camera.height <= 0) Fail(name + " has no size");
    if (camera.params.size() != static_cast<std::size_t>(info.num_params)) {
      Fail(name + " has " + std::to_string(camera.params.size()) + " parameters, not the " +
           std::to_string(info.num_params) + " of " + info.name);
    }
    for (const double param : camera.params) {
      if (!std::isfinite(param)) Fail(name + " has a parameter that is not a finite number");
    }
    const PinholeCamera pinhole = ToPinhole(camera);
    if (!(pinhole.fx > 0 && pinhole.fy > 0)) Fail(name + " has a focal length that is not > 0");
  }

  void CheckImage(ImageId id, const SparseImage& image) {
    const std::string name = "image " + std::to_string(id) + " '" + image.name + "'";
    if (image.name.empty()) Fail("image " + std::to_string(id) + " has no name");
    for (const char c : image.name) {
      if (static_cast<unsigned char>(c) < 32) {
        Fail("image " + std::to_string(id) + " has a control character in its name");
      }
    }
    if (!model_.cameras.contains(image.camera_id)) {
      Fail(name + " has camera " + std::to_string(image.camera_id) + ", which does not exist");
    }
    const Rigid3d& pose = image.cam_from_world;
    if (!(std::abs(pose.rotation.norm() - 1) < 1e-6) || !pose.translation.allFinite()) {
      Fail(name + " has a pose that is no rotation and finite translation");
    }
    for (std::size_t i = 0; i < image.keypoints.size(); ++i) {
      CheckKeypoint(name, i, image.keypoints[i]);
    }
  }

  void CheckKeypoint(const std::string& image_name, std::size_t index, const Keypoint2D& keypoint) {
    if (!keypoint.pixel.allFinite()) {
      Fail(image_name + " has keypoint " + std::to_string(index) + " at no finite place");
    }
    if (keypoint.point3D_id == kInvalidPoint3DId) return;
    if (!model_.points.contains(keypoint.point3D_id)) {
      Fail(image_name + " has keypoint " + std::to_string(index) + " of point " +
           std::to_string(keypoint.point3D_id) + ", which does not exist");
    }
    ++num_keypoints_of_point_[keypoint.point3D_id];
  }

  // Runs after all images: track elements and keypoints must name each other one to one.
  void CheckPoint(Point3DId id, const SparsePoint& point) const {
    const std::string name = "point " + std::to_string(id);
    if (id == kInvalidPoint3DId) Fail(name + " has the id that means 'no point'");
    if (!point.position.allFinite() || !std::isfinite(point.error_px)) {
      Fail(name + " has a position or error that is not a finite number");
    }
    for (const TrackElement& element : point.track) CheckTrackElement(id, element);
    const auto found = num_keypoints_of_point_.find(id);
    const std::size_t num_keypoints = found == num_keypoints_of_point_.end() ? 0 : found->second;
    if (num_keypoints != point.track.size()) {
      Fail(name + " has a track of " + std::to_string(point.track.size()) + " elements, but " +
           std::to_string(num_keypoints) + " keypoints belong to it");
    }
  }

  void CheckTrackElement(Point3DId id, const TrackElement& element) const {
    const std::string name = "point " + std::to_string(id);
    const auto image = model_.images.find(element.image_id);
    if (image == model_.images.end()) {
      Fail(name + " was seen in image " + std::to_string(element.image_id) +
           ", which does not exist");
    }
    const std::vector<Keypoint2D>& keypoints = image->second.keypoints;
    if (element.keypoint_index >= keypoints.size() ||
        keypoints[element.keypoint_index].point3D_id != id) {
      Fail(name + " was seen as keypoint " + std::to_string(element.keypoint_index) + " of image " +
           std::to_string(element.image_id) + ", which is not there or belongs to another point");
    }
  }

  void CheckFrames() const {
    const std::string problem = ProblemOf(model_.frame_table);
    if (!problem.empty()) Fail(problem);
    for (const auto& [id, frame] : model_.frame_table.frames) {
      for (const FrameData& data : frame.data) {
        if (data.sensor.type != SensorType::kCamera) continue;
        const auto image = model_.images.find(static_cast<ImageId>(data.id));
        if (image == model_.images.end() || image->second.camera_id == data.sensor.id) continue;
        Fail("frame " + std::to_string(id) + " has photo '" + image->second.name + "' of camera " +
             std::to_string(data.sensor.id) + ", which is of camera " +
             std::to_string(image->second.camera_id));
      }
    }
  }

  const Reconstruction& model_;
  const std::string& where_;
  std::unordered_map<Point3DId, std::size_t> num_keypoints_of_point_;
};

}  // namespace

void CheckConsistency(const Reconstruction& reconstruction, const std::string& where) {
  Checker(reconstruction, where).Run();
}

void TransformReconstruction(const Sim3d& new_from_old, Reconstruction* reconstruction) {
  for (auto& [id, image] : reconstruction->images) {
    image.cam_from_world = TransformCameraWorld(new_from_old, image.cam_from_world);
  }
  for (auto& [id, point] : reconstruction->points) point.position = new_from_old * point.position;
  for (auto& [id, rig] : reconstruction->frame_table.rigs) {
    for (auto& [sensor, sensor_from_rig] : rig.sensor_from_rig) {
      if (sensor_from_rig) sensor_from_rig->translation *= new_from_old.scale;
    }
  }
}

}  // namespace colmap_ext
