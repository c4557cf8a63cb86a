// Layout: https://colmap.github.io/format.html#binary-file-format
#include <cstdint>
#include <utility>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/byte_reader.h"
#include "scene/reconstruction_files.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

// Smallest records: fixed fields with empty lists and names.
constexpr std::size_t kMinCameraBytes = 4 + 4 + 8 + 8 + 3 * 8;
constexpr std::size_t kMinImageBytes = 4 + 7 * 8 + 4 + 1 + 8;
constexpr std::size_t kKeypointBytes = 2 * 8 + 8;
constexpr std::size_t kMinPointBytes = 8 + 3 * 8 + 3 + 8 + 8;
constexpr std::size_t kTrackElementBytes = 4 + 4;

int ReadImageSide(ByteReader& in, const char* what) {
  const auto side = in.Read<std::uint64_t>(what);
  if (side == 0 || side > kMaxImageSide) {
    in.Fail(std::string(what) + " is " + std::to_string(side) + " pixels; the file is corrupt");
  }
  return static_cast<int>(side);
}

std::map<CameraId, Camera> ReadCamerasBinary(const fs::path& path) {
  ByteReader in(path);
  std::map<CameraId, Camera> cameras;
  const std::size_t count = in.ReadCount(kMinCameraBytes, "the number of cameras");
  for (std::size_t i = 0; i < count; ++i) {
    const auto id = in.Read<CameraId>("a camera's id");
    const auto model_id = in.Read<std::int32_t>("a camera's model");
    const CameraModelInfo* info = nullptr;
    try {
      info = &GetCameraModelInfo(model_id);
    } catch (const Error& error) {
      in.Fail("camera " + std::to_string(id) + " has an " + error.what());
    }
    Camera camera;
    camera.model = info->model;
    camera.width = ReadImageSide(in, "a camera's width");
    camera.height = ReadImageSide(in, "a camera's height");
    camera.params.resize(static_cast<std::size_t>(info->num_params));
    for (double& param : camera.params) param = in.Read<double>("a camera's parameters");
    if (!cameras.emplace(id, std::move(camera)).second) {
      in.Fail("camera " + std::to_string(id) + " is there twice; the file is corrupt");
    }
  }
  in.ExpectEnd();
  return cameras;
}

SparseImage ReadImage(ByteReader& in) {
  SparseImage image;
  double q[4], t[3];
  for (double& value : q) value = in.Read<double>("an image's rotation");
  for (double& value : t) value = in.Read<double>("an image's translation");
  image.cam_from_world.rotation = RotationFromFile(q[0], q[1], q[2], q[3]);
  image.cam_from_world.translation = {t[0], t[1], t[2]};
  image.camera_id = in.Read<CameraId>("an image's camera id");
  image.name = in.ReadCString("an image's name");
  image.keypoints.resize(in.ReadCount(kKeypointBytes, "an image's number of keypoints"));
  for (Keypoint2D& keypoint : image.keypoints) {
    keypoint.pixel.x() = in.Read<double>("a keypoint");
    keypoint.pixel.y() = in.Read<double>("a keypoint");
    keypoint.point3D_id = in.Read<Point3DId>("a keypoint");
  }
  return image;
}

std::map<ImageId, SparseImage> ReadImagesBinary(const fs::path& path) {
  ByteReader in(path);
  std::map<ImageId, SparseImage> images;
  const std::size_t count = in.ReadCount(kMinImageBytes, "the number of images");
  for (std::size_t i = 0; i < count; ++i) {
    const auto id = in.Read<ImageId>("an image's id");
    if (!images.emplace(id, ReadImage(in)).second) {
      in.Fail("image " + std::to_string(id) + " is there twice; the file is corrupt");
    }
  }
  in.ExpectEnd();
  return images;
}

SparsePoint ReadPoint(ByteReader& in) {
  SparsePoint point;
  for (int axis = 0; axis < 3; ++axis) point.position[axis] = in.Read<double>("a point's position");
  for (int channel = 0; channel < 3; ++channel) {
    point.color[channel] = in.Read<std::uint8_t>("a point's colour");
  }
  point.error_px = in.Read<double>("a point's error");
  point.track.resize(in.ReadCount(kTrackElementBytes, "a point's track length"));
  for (TrackElement& element : point.track) {
    element.image_id = in.Read<ImageId>("a point's track");
    element.keypoint_index = in.Read<std::uint32_t>("a point's track");
  }
  return point;
}

std::map<Point3DId, SparsePoint> ReadPointsBinary(const fs::path& path) {
  ByteReader in(path);
  std::map<Point3DId, SparsePoint> points;
  const std::size_t count = in.ReadCount(kMinPointBytes, "the number of points");
  for (std::size_t i = 0; i < count; ++i) {
    const auto id = in.Read<Point3DId>("a point's id");
    if (!points.emplace(id, ReadPoint(in)).second) {
      in.Fail("point " + std::to_string(id) + " is there twice; the file is corrupt");
    }
  }
  in.ExpectEnd();
  return points;
}

void WriteCamerasBinary(const std::map<CameraId, Camera>& cameras, std::ostream& out) {
  WriteBytes<std::uint64_t>(out, cameras.size());
  for (const auto& [id, camera] : cameras) {
    WriteBytes<CameraId>(out, id);
    WriteBytes<std::int32_t>(out, static_cast<std::int32_t>(camera.model));
    WriteBytes<std::uint64_t>(out, static_cast<std::uint64_t>(camera.width));
    WriteBytes<std::uint64_t>(out, static_cast<std::uint64_t>(camera.height));
    for (const double param : camera.params) WriteBytes<double>(out, param);
  }
}

void WriteImagesBinary(const std::map<ImageId, SparseImage>& images, std::ostream& out) {
  WriteBytes<std::uint64_t>(out, images.size());
  for (const auto& [id, image] : images) {
    WriteBytes<ImageId>(out, id);
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) WriteBytes<double>(out, value);
    for (const double value : image.cam_from_world.translation) WriteBytes<double>(out, value);
    WriteBytes<CameraId>(out, image.camera_id);
    out.write(image.name.c_str(), static_cast<std::streamsize>(image.name.size() + 1));
    WriteBytes<std::uint64_t>(out, image.keypoints.size());
    for (const Keypoint2D& keypoint : image.keypoints) {
      WriteBytes<double>(out, keypoint.pixel.x());
      WriteBytes<double>(out, keypoint.pixel.y());
      WriteBytes<Point3DId>(out, keypoint.point3D_id);
    }
  }
}

void WritePointsBinary(const std::map<Point3DId, SparsePoint>& points, std::ostream& out) {
  WriteBytes<std::uint64_t>(out, points.size());
  for (const auto& [id, point] : points) {
    WriteBytes<Point3DId>(out, id);
    for (const double value : point.position) WriteBytes<double>(out, value);
    for (const std::uint8_t value : point.color) WriteBytes<std::uint8_t>(out, value);
    WriteBytes<double>(out, point.error_px);
    WriteBytes<std::uint64_t>(out, point.track.size());
    for (const TrackElement& element : point.track) {
      WriteBytes<ImageId>(out, element.image_id);
      WriteBytes<std::uint32_t>(out, element.keypoint_index);
    }
  }
}

}  // namespace

Reconstruction ReadBinaryModel(const fs::path& folder) {
  return {ReadCamerasBinary(folder / "cameras.bin"), ReadImagesBinary(folder / "images.bin"),
          ReadPointsBinary(folder / "points3D.bin")};
}

void WriteReconstructionBinary(const Reconstruction& reconstruction, const fs::path& folder) {
  CheckConsistency(reconstruction, "the model to be written to " + folder.string());
  RequireNoForeignFrames(reconstruction, folder);
  if (!reconstruction.frame_table.IsEmpty()) WriteBinaryFrameTable(reconstruction, folder);
  WriteFileAtomically(folder / "cameras.bin",
                      [&](std::ostream& out) { WriteCamerasBinary(reconstruction.cameras, out); });
  WriteFileAtomically(folder / "images.bin",
                      [&](std::ostream& out) { WriteImagesBinary(reconstruction.images, out); });
  WriteFileAtomically(folder / "points3D.bin",
                      [&](std::ostream& out) { WritePointsBinary(reconstruction.points, out); });
}

}  // namespace colmap_ext
