#include "view_places.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace colmap_ext {
namespace {

Eigen::Vector3d OpticalAxis(const Rigid3d& cam_from_world) {
  return cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
}

std::optional<Eigen::Vector3d> AxisFromMetadata(const PhotoMetadata& metadata) {
  if (!metadata.yaw_rad || !metadata.pitch_rad) return std::nullopt;
  return DirectionInWorld({*metadata.yaw_rad, *metadata.pitch_rad});
}

// Poses of the given model by name, when they are in the same frame as the catalog's positions.
std::map<std::string, Rigid3d> TrustedPoses(const SparseUpdateInput& input,
                                            const PhotoCatalog& catalog) {
  std::map<std::string, Rigid3d> poses;
  if (input.model == nullptr || !input.frame.is_metric_enu) return poses;
  const bool same_frame = input.frame.origin.has_value() == catalog.origin.has_value();
  if (!same_frame) return poses;
  for (const auto& [id, image] : input.model->images) poses[image.name] = image.cam_from_world;
  return poses;
}

}  // namespace

std::vector<PhotoPlace> PlacesOf(const SparseUpdateInput& input, const PhotoCatalog& catalog) {
  const std::map<std::string, Rigid3d> poses = TrustedPoses(input, catalog);
  std::vector<PhotoPlace> places;
  for (const CatalogPhoto& photo : catalog.photos) {
    PhotoPlace place;
    const auto pose = poses.find(photo.name);
    if (pose != poses.end()) {
      place.position_m = CameraCenter(pose->second);
      place.optical_axis = OpticalAxis(pose->second);
    } else {
      place.position_m = photo.position_in_world;
      place.optical_axis = AxisFromMetadata(photo.metadata);
    }
    places.push_back(place);
  }
  return places;
}

std::vector<MeasuredCamera> MeasuredCamerasOf(const Reconstruction& model,
                                              const PhotoCatalog& catalog) {
  std::map<std::string, Rigid3d> poses;
  for (const auto& [id, image] : model.images) poses[image.name] = image.cam_from_world;
  std::vector<MeasuredCamera> cameras;
  for (const CatalogPhoto& photo : catalog.photos) {
    const auto pose = poses.find(photo.name);
    if (pose == poses.end() || !photo.position_in_world) continue;
    MeasuredCamera camera;
    camera.name = photo.name;
    camera.cam_from_model = pose->second;
    camera.position_in_world = *photo.position_in_world;
    camera.sigma_horizontal_m = photo.sigma_horizontal_m.value_or(camera.sigma_horizontal_m);
    camera.sigma_vertical_m = photo.sigma_vertical_m.value_or(camera.sigma_vertical_m);
    camera.up_in_cam = photo.up_in_cam;
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<Eigen::Vector3d> OpticalAxes(const Reconstruction& model) {
  std::vector<Eigen::Vector3d> axes;
  for (const auto& [id, image] : model.images) axes.push_back(OpticalAxis(image.cam_from_world));
  return axes;
}

bool AllLookOneWay(const std::vector<Eigen::Vector3d>& axes) {
  const double min_cosine = std::cos(DegToRad(15));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& axis : axes) sum += axis;
  return std::all_of(axes.begin(), axes.end(), [&](const Eigen::Vector3d& axis) {
    return axis.dot(sum.normalized()) >= min_cosine;
  });
}

bool AllFocalsKnown(const PhotoCatalog& catalog) {
  return std::all_of(catalog.photos.begin(), catalog.photos.end(),
                     [](const CatalogPhoto& photo) { return photo.metadata.focal_px.has_value(); });
}

bool RefineIntrinsics(const SparseUpdateOptions& options, const SparseUpdateInput& input,
                      const PhotoCatalog& catalog) {
  if (options.refine_intrinsics >= 0) return options.refine_intrinsics == 1;
  if (input.camera) return false;
  if (!AllFocalsKnown(catalog)) return true;
  std::vector<Eigen::Vector3d> axes;
  for (const CatalogPhoto& photo : catalog.photos) {
    const std::optional<Eigen::Vector3d> axis = AxisFromMetadata(photo.metadata);
    if (!axis) return true;  // unknown: look at the model afterwards
    axes.push_back(*axis);
  }
  return !AllLookOneWay(axes);
}

}  // namespace colmap_ext
