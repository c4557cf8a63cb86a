#include "colmap_ext/scene/photo.h"

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/parallel.h"
#include "scene/picture_stream.h"
#include "scene/undistort.h"

namespace colmap_ext {
namespace {

const Camera& CameraOf(const Reconstruction& reconstruction, const SparseImage& image) {
  const auto it = reconstruction.cameras.find(image.camera_id);
  if (it == reconstruction.cameras.end()) {
    throw Error("photo " + image.name + ": the model has no camera " +
                std::to_string(image.camera_id));
  }
  return it->second;
}

std::vector<PosedPhoto> PhotosSortedByName(const Reconstruction& reconstruction) {
  std::vector<PosedPhoto> photos;
  for (const auto& [image_id, image] : reconstruction.images) {
    PosedPhoto photo;
    photo.image_id = image_id;
    photo.name = image.name;
    photo.lens = CameraOf(reconstruction, image);
    photo.camera = ToPinhole(photo.lens);
    photo.cam_from_world = image.cam_from_world;
    photos.push_back(std::move(photo));
  }
  std::sort(photos.begin(), photos.end(),
            [](const PosedPhoto& a, const PosedPhoto& b) { return a.name < b.name; });
  return photos;
}

// Mean distance between the keypoints of a track and the projections of its point; 0 for a point
// without a projection.
double ReprojectionError(const Reconstruction& reconstruction, const SparsePoint& point) {
  double sum = 0;
  int count = 0;
  for (const TrackElement& element : point.track) {
    const SparseImage& image = reconstruction.images.at(element.image_id);
    const Eigen::Vector3d point_in_cam = image.cam_from_world * point.position;
    if (point_in_cam.z() <= 0) continue;
    const Eigen::Vector2d projection =
        ImageFromNormalized(CameraOf(reconstruction, image), point_in_cam.hnormalized());
    sum += (image.keypoints.at(element.keypoint_index).pixel - projection).norm();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

std::vector<SupportPoint> SupportPoints(const Reconstruction& reconstruction,
                                        const std::vector<PosedPhoto>& photos) {
  std::map<ImageId, int> index_of_image;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    index_of_image[photos[i].image_id] = static_cast<int>(i);
  }
  std::vector<SupportPoint> points;
  points.reserve(reconstruction.points.size());
  for (const auto& [point_id, sparse] : reconstruction.points) {
    SupportPoint point;
    point.position = sparse.position;
    for (const TrackElement& element : sparse.track) {
      const auto it = index_of_image.find(element.image_id);
      if (it == index_of_image.end()) {
        throw Error("point " + std::to_string(point_id) + ": the model has no image " +
                    std::to_string(element.image_id));
      }
      point.photo_indices.push_back(it->second);
    }
    std::sort(point.photo_indices.begin(), point.photo_indices.end());
    point.photo_indices.erase(std::unique(point.photo_indices.begin(), point.photo_indices.end()),
                              point.photo_indices.end());
    point.error_px =
        sparse.error_px >= 0 ? sparse.error_px : ReprojectionError(reconstruction, sparse);
    points.push_back(std::move(point));
  }
  return points;
}

void CheckSize(const cv::Mat& picture, const Camera& camera, const std::string& path) {
  if (picture.cols == camera.width && picture.rows == camera.height) return;
  throw Error(path + ": the photo has " + std::to_string(picture.cols) + " x " +
              std::to_string(picture.rows) + " pixels, its camera in the model " +
              std::to_string(camera.width) + " x " + std::to_string(camera.height) +
              "; was it resized after the model was made?");
}

}  // namespace

PhotoSet LoadPhotoSet(const Reconstruction& reconstruction, const std::string& image_path,
                      bool with_pixels) {
  PhotoSet set;
  set.photos = PhotosSortedByName(reconstruction);
  set.points = SupportPoints(reconstruction, set.photos);
  if (with_pixels) {
    const std::vector<std::uint8_t> all(set.photos.size(), 1);
    LoadPixels(reconstruction, image_path, all, &set.photos);
  }
  return set;
}

void LoadPixels(const Reconstruction& reconstruction, const std::string& image_path,
                const std::vector<std::uint8_t>& which, std::vector<PosedPhoto>* photos) {
  std::map<CameraId, cv::Mat> map_of_camera;
  for (const PosedPhoto& photo : *photos) {
    const CameraId camera_id = reconstruction.images.at(photo.image_id).camera_id;
    if (!IsPinhole(photo.lens) && !map_of_camera.contains(camera_id)) {
      map_of_camera[camera_id] = BuildUndistortMap(photo.lens, ToPinhole(photo.lens));
    }
  }
  ParallelForEach(photos->size(), [&](std::size_t i) {
    if (which[i] == 0) return;
    PosedPhoto& photo = (*photos)[i];
    const CameraId camera_id = reconstruction.images.at(photo.image_id).camera_id;
    const std::string path = (std::filesystem::path(image_path) / photo.name).string();
    photo.bgr = ReadPhoto(path);
    CheckSize(photo.bgr, photo.lens, path);
    const auto map = map_of_camera.find(camera_id);
    if (map != map_of_camera.end()) photo.bgr = Undistort(photo.bgr, map->second);
    const cv::Size size(photo.camera.width, photo.camera.height);
    if (photo.bgr.size() != size) cv::resize(photo.bgr, photo.bgr, size, 0, 0, cv::INTER_AREA);
  });
}

cv::Mat ReadPhoto(const std::string& path) {
  RequireFile(path, "photo");
  const std::string bytes = ReadFile(path);
  const std::string defect = FindPictureDefect(bytes);
  if (!defect.empty()) throw Error(path + ": cannot be used as a photo: " + defect);
  cv::Mat picture;
  std::string reason = "its data are corrupt";
  try {
    const std::vector<unsigned char> buffer(bytes.begin(), bytes.end());
    picture = cv::imdecode(buffer, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    reason = e.err;
  }
  if (picture.empty()) throw Error(path + ": cannot be decoded as a photo: " + reason);
  return picture;
}

void WritePhoto(const cv::Mat& bgr, const std::filesystem::path& path, int jpeg_quality) {
  std::vector<std::uint8_t> bytes;
  if (!cv::haveImageWriter(path.string()) ||
      !cv::imencode(path.extension().string(), bgr, bytes,
                    {cv::IMWRITE_JPEG_QUALITY, jpeg_quality})) {
    throw Error("cannot encode " + path.string() + "; is its extension a picture's?");
  }
  WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

std::vector<std::vector<int>> RankPartners(
    const PhotoSet& photos,
    const std::function<double(const Eigen::Vector3d& ray_a, const Eigen::Vector3d& ray_b)>& score,
    int max_partners) {
  const std::size_t n = photos.photos.size();
  std::vector<Eigen::Vector3d> centers;
  for (const PosedPhoto& photo : photos.photos) {
    centers.push_back(CameraCenter(photo.cam_from_world));
  }
  std::vector<std::vector<const SupportPoint*>> points_of_photo(n);
  for (const SupportPoint& point : photos.points) {
    for (const int i : point.photo_indices) {
      points_of_photo[static_cast<std::size_t>(i)].push_back(&point);
    }
  }
  std::vector<std::vector<int>> partners(n);
  ParallelFor(n, [&](std::size_t i) {
    std::vector<double> sum(n);
    for (const SupportPoint* point : points_of_photo[i]) {
      const Eigen::Vector3d ray_i = point->position - centers[i];
      for (const int j : point->photo_indices) {
        const auto other = static_cast<std::size_t>(j);
        if (other == i) continue;
        const Eigen::Vector3d ray_j = point->position - centers[other];
        // The lower index first: both photos of a pair get the same.
        sum[other] += std::max(0.0, i < other ? score(ray_i, ray_j) : score(ray_j, ray_i));
      }
    }
    std::vector<std::pair<double, int>> ranked;
    for (std::size_t j = 0; j < n; ++j) {
      if (sum[j] > 0) ranked.emplace_back(-sum[j], static_cast<int>(j));
    }
    const std::size_t count = std::min(ranked.size(), static_cast<std::size_t>(max_partners));
    std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count),
                      ranked.end());
    for (std::size_t r = 0; r < count; ++r) partners[i].push_back(ranked[r].second);
  });
  return partners;
}

}  // namespace colmap_ext
