#include "pair_stage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "view_places.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kSamplesOfPhoto = 40;
constexpr std::size_t kSamplesOfModel = 4000;

void SetFieldOfView(const Camera& camera, PhotoPlace* place) {
  const PinholeCamera pinhole = ToPinhole(camera);
  place->half_width = 0.5 * pinhole.width / pinhole.fx;
  place->half_height = 0.5 * pinhole.height / pinhole.fy;
}

// Every so-manieth of `all`, at most `count`.
template <typename T>
std::vector<T> Thinned(const std::vector<T>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

std::vector<Eigen::Vector3d> PointsOf(const SparseImage& image, const Reconstruction& model) {
  std::vector<Eigen::Vector3d> points;
  for (const Keypoint2D& keypoint : image.keypoints) {
    if (keypoint.point3D_id == kInvalidPoint3DId) continue;
    points.push_back(model.points.at(keypoint.point3D_id).position);
  }
  return Thinned(points, kSamplesOfPhoto);
}

// A point of the surface, and from where one photo saw it: points are not seen through walls.
struct SurfacePoint {
  Eigen::Vector3d position, toward_camera;
};

std::vector<SurfacePoint> SurfaceOf(const Reconstruction& model) {
  const std::size_t step = model.points.size() / kSamplesOfModel + 1;
  std::vector<SurfacePoint> surface;
  std::size_t index = 0;
  for (const auto& [id, point] : model.points) {
    if (index++ % step != 0 || point.track.empty()) continue;
    const Rigid3d& pose = model.images.at(point.track.front().image_id).cam_from_world;
    surface.push_back({point.position, (CameraCenter(pose) - point.position).normalized()});
  }
  return surface;
}

// What a photo should show of the surface; nothing where it looks at new parts mostly.
std::vector<Eigen::Vector3d> PredictedPoints(const PhotoPlace& place,
                                             const std::vector<SurfacePoint>& surface) {
  constexpr std::size_t kFewest = 12;
  const double min_cosine = std::cos(DegToRad(60));
  const Eigen::Vector3d& axis = *place.optical_axis;
  const Rigid3d cam_from_world =
      CamFromWorld(*place.position_m,
                   {std::atan2(axis.x(), axis.y()), std::asin(std::clamp(axis.z(), -1., 1.))});
  std::vector<Eigen::Vector3d> points;
  for (const SurfacePoint& point : surface) {
    const Eigen::Vector3d in_cam = cam_from_world * point.position;
    if (!(in_cam.z() > 0) || std::abs(in_cam.x()) > place.half_width * in_cam.z() ||
        std::abs(in_cam.y()) > place.half_height * in_cam.z()) {
      continue;
    }
    const Eigen::Vector3d toward = (*place.position_m - point.position).normalized();
    if (toward.dot(point.toward_camera) >= min_cosine) points.push_back(point.position);
  }
  return points.size() < kFewest ? std::vector<Eigen::Vector3d>()
                                 : Thinned(points, kSamplesOfPhoto);
}

// The photos of the catalog as the database and the model number them.
struct NumberedPhotos {
  std::vector<ImageId> ids;  // in the order of the catalog
  std::map<ImageId, int> index_of_id;
};

NumberedPhotos NumberPhotos(const std::map<ImageId, DatabaseImage>& images,
                            const PhotoCatalog& catalog) {
  std::map<std::string, ImageId> id_of_name;
  for (const auto& [id, image] : images) id_of_name[image.name] = id;
  NumberedPhotos photos;
  for (const CatalogPhoto& photo : catalog.photos) {
    photos.ids.push_back(id_of_name.at(photo.name));
    photos.index_of_id[photos.ids.back()] = static_cast<int>(photos.ids.size()) - 1;
  }
  return photos;
}

// Adds to the places what the cameras and the model know.
void AddViews(const DatabaseView& database, const std::map<ImageId, DatabaseImage>& images,
              const NumberedPhotos& photos, const std::vector<bool>& is_new,
              const SparseUpdateInput& input, std::vector<PhotoPlace>* places) {
  const std::map<CameraId, DatabaseCamera> cameras = database.ReadCameras();
  const bool in_frame = input.model != nullptr && input.frame.is_metric_enu;
  const std::vector<SurfacePoint> surface =
      in_frame ? SurfaceOf(*input.model) : std::vector<SurfacePoint>();
  for (std::size_t i = 0; i < places->size(); ++i) {
    PhotoPlace& place = (*places)[i];
    SetFieldOfView(cameras.at(images.at(photos.ids[i]).camera_id).camera, &place);
    if (!in_frame || !place.position_m || !place.optical_axis) continue;
    const auto image = input.model->images.find(photos.ids[i]);
    if (image != input.model->images.end()) {
      place.seen_points = PointsOf(image->second, *input.model);
    } else if (is_new[i]) {
      place.seen_points = PredictedPoints(place, surface);
    }
  }
}

}  // namespace

std::vector<ImagePair> ChooseImagePairs(const DatabaseView& database, const PhotoCatalog& catalog,
                                        const SparseUpdateInput& input,
                                        const PairingOptions& options) {
  const std::map<ImageId, DatabaseImage> images = database.ReadImages();
  const NumberedPhotos photos = NumberPhotos(images, catalog);
  std::vector<bool> is_new(photos.ids.size(), true);
  std::set<PhotoPair> existing;
  for (const ImagePair& pair : database.TriedPairs()) {
    const auto first = photos.index_of_id.find(pair.first);
    const auto second = photos.index_of_id.find(pair.second);
    for (const auto& found : {first, second}) {
      if (found != photos.index_of_id.end()) {
        is_new[static_cast<std::size_t>(found->second)] = false;
      }
    }
    if (first == photos.index_of_id.end() || second == photos.index_of_id.end()) continue;
    existing.insert(
        {std::min(first->second, second->second), std::max(first->second, second->second)});
  }
  std::vector<PhotoPlace> places = PlacesOf(input, catalog);
  AddViews(database, images, photos, is_new, input, &places);
  std::vector<ImagePair> pairs;
  for (const PhotoPair& pair : ChoosePairs(places, is_new, existing, options)) {
    const ImageId a = photos.ids[static_cast<std::size_t>(pair.first)];
    const ImageId b = photos.ids[static_cast<std::size_t>(pair.second)];
    pairs.emplace_back(std::min(a, b), std::max(a, b));
  }
  return pairs;
}

}  // namespace colmap_ext
