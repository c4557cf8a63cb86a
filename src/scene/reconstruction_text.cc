// Layout: https://colmap.github.io/format.html#text-format
#include <charconv>
#include <cstdint>
#include <limits>
#include <utility>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/reconstruction_files.h"
#include "scene/text_reader.h"

namespace colmap_ext {
namespace fs = std::filesystem;
namespace {

int NextImageSide(TextReader& in, const char* what) {
  const auto side = in.Next<std::uint64_t>(what);
  if (side == 0 || side > kMaxImageSide) {
    in.Fail(std::string(what) + " is " + std::to_string(side) + " pixels; the file is corrupt");
  }
  return static_cast<int>(side);
}

const CameraModelInfo& NextCameraModel(TextReader& in) {
  const auto word = in.NextWord();
  if (!word) in.Fail("there is no column for the camera model");
  try {
    return GetCameraModelInfo(std::string(*word));
  } catch (const Error& error) {
    in.Fail(error.what());
  }
}

std::map<CameraId, Camera> ReadCamerasText(const fs::path& path) {
  TextReader in(path);
  std::map<CameraId, Camera> cameras;
  while (in.NextRecord()) {
    const auto id = in.Next<CameraId>("CAMERA_ID");
    const CameraModelInfo& info = NextCameraModel(in);
    Camera camera;
    camera.model = info.model;
    camera.width = NextImageSide(in, "WIDTH");
    camera.height = NextImageSide(in, "HEIGHT");
    while (const auto word = in.NextWord()) {
      camera.params.push_back(in.Parse<double>(*word, "PARAMS[]"));
    }
    if (camera.params.size() != static_cast<std::size_t>(info.num_params)) {
      in.Fail("camera model " + std::string(info.name) + " has " + std::to_string(info.num_params) +
              " parameters, the line has " + std::to_string(camera.params.size()));
    }
    if (!cameras.emplace(id, std::move(camera)).second) {
      in.Fail("camera " + std::to_string(id) + " is there twice");
    }
  }
  return cameras;
}

// POINT3D_ID of a keypoint: -1 means none.
Point3DId NextPoint3DId(TextReader& in) {
  const auto word = in.NextWord();
  if (!word) in.Fail("the number of columns is not a multiple of 3 (X, Y, POINT3D_ID)");
  if (*word == "-1") return kInvalidPoint3DId;
  return in.Parse<Point3DId>(*word, "POINT3D_ID");
}

void ReadKeypointLine(TextReader& in, SparseImage* image) {
  if (!in.NextLine()) {
    in.Fail(
        "image '" + image->name +
        "' has no line of keypoints after it; the file is truncated (the line may be empty, but "
        "must be there)");
  }
  while (const auto word = in.NextWord()) {
    Keypoint2D keypoint;
    keypoint.pixel.x() = in.Parse<double>(*word, "X");
    keypoint.pixel.y() = in.Next<double>("Y");
    keypoint.point3D_id = NextPoint3DId(in);
    image->keypoints.push_back(keypoint);
  }
}

std::map<ImageId, SparseImage> ReadImagesText(const fs::path& path) {
  TextReader in(path);
  std::map<ImageId, SparseImage> images;
  while (in.NextRecord()) {
    const auto id = in.Next<ImageId>("IMAGE_ID");
    double q[4], t[3];
    for (double& value : q) value = in.Next<double>("QW, QX, QY, QZ");
    for (double& value : t) value = in.Next<double>("TX, TY, TZ");
    SparseImage image;
    image.cam_from_world.rotation = RotationFromFile(q[0], q[1], q[2], q[3]);
    image.cam_from_world.translation = {t[0], t[1], t[2]};
    image.camera_id = in.Next<CameraId>("CAMERA_ID");
    image.name = in.Rest();
    if (image.name.empty()) in.Fail("there is no column for NAME");
    ReadKeypointLine(in, &image);
    if (!images.emplace(id, std::move(image)).second) {
      in.Fail("image " + std::to_string(id) + " is there twice");
    }
  }
  return images;
}

std::map<Point3DId, SparsePoint> ReadPointsText(const fs::path& path) {
  TextReader in(path);
  std::map<Point3DId, SparsePoint> points;
  while (in.NextRecord()) {
    const auto id = in.Next<Point3DId>("POINT3D_ID");
    SparsePoint point;
    for (int axis = 0; axis < 3; ++axis) point.position[axis] = in.Next<double>("X, Y, Z");
    for (int channel = 0; channel < 3; ++channel) {
      point.color[channel] = in.Next<std::uint8_t>("R, G, B (0 to 255)");
    }
    point.error_px = in.Next<double>("ERROR");
    while (const auto word = in.NextWord()) {
      const auto image_id = in.Parse<ImageId>(*word, "IMAGE_ID");
      point.track.push_back({image_id, in.Next<std::uint32_t>("POINT2D_IDX")});
    }
    if (!points.emplace(id, std::move(point)).second) {
      in.Fail("point " + std::to_string(id) + " is there twice");
    }
  }
  return points;
}

void WriteCamerasText(const std::map<CameraId, Camera>& cameras, std::ostream& out) {
  out << "# Camera list with one line of data per camera:\n"
         "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
         "# Number of cameras: "
      << cameras.size() << '\n';
  for (const auto& [id, camera] : cameras) {
    out << id << ' ' << GetCameraModelInfo(static_cast<int>(camera.model)).name << ' '
        << camera.width << ' ' << camera.height;
    for (const double param : camera.params) out << ' ' << Digits{param};
    out << '\n';
  }
}

void WriteImagesText(const std::map<ImageId, SparseImage>& images, std::ostream& out) {
  out << "# Image list with two lines of data per image:\n"
         "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
         "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
         "# Number of images: "
      << images.size() << '\n';
  for (const auto& [id, image] : images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    out << id;
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) out << ' ' << Digits{value};
    for (const double value : image.cam_from_world.translation) out << ' ' << Digits{value};
    out << ' ' << image.camera_id << ' ' << image.name << '\n';
    const char* separator = "";
    for (const Keypoint2D& keypoint : image.keypoints) {
      out << separator << Digits{keypoint.pixel.x()} << ' ' << Digits{keypoint.pixel.y()} << ' ';
      if (keypoint.point3D_id == kInvalidPoint3DId) {
        out << "-1";
      } else {
        out << keypoint.point3D_id;
      }
      separator = " ";
    }
    out << '\n';
  }
}

void WritePointsText(const std::map<Point3DId, SparsePoint>& points, std::ostream& out) {
  out << "# 3D point list with one line of data per point:\n"
         "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
         "# Number of points: "
      << points.size() << '\n';
  for (const auto& [id, point] : points) {
    out << id;
    for (const double value : point.position) out << ' ' << Digits{value};
    for (const std::uint8_t value : point.color) out << ' ' << static_cast<int>(value);
    out << ' ' << Digits{point.error_px};
    for (const TrackElement& element : point.track) {
      out << ' ' << element.image_id << ' ' << element.keypoint_index;
    }
    out << '\n';
  }
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const Digits& digits) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), digits.value);
  return out.write(buffer, result.ptr - buffer);
}

Reconstruction ReadTextModel(const fs::path& folder) {
  return {ReadCamerasText(folder / "cameras.txt"), ReadImagesText(folder / "images.txt"),
          ReadPointsText(folder / "points3D.txt")};
}

void WriteReconstructionText(const Reconstruction& reconstruction, const fs::path& folder) {
  CheckConsistency(reconstruction, "the model to be written to " + folder.string());
  if (fs::exists(folder / "cameras.bin")) {
    throw Error((folder / "cameras.bin").string() +
                ": a binary model is there and would be read before the text; write the text to "
                "another folder");
  }
  RequireNoForeignFrames(reconstruction, folder);
  if (!reconstruction.frame_table.IsEmpty()) WriteTextFrameTable(reconstruction, folder);
  WriteFileAtomically(folder / "cameras.txt",
                      [&](std::ostream& out) { WriteCamerasText(reconstruction.cameras, out); });
  WriteFileAtomically(folder / "images.txt",
                      [&](std::ostream& out) { WriteImagesText(reconstruction.images, out); });
  WriteFileAtomically(folder / "points3D.txt",
                      [&](std::ostream& out) { WritePointsText(reconstruction.points, out); });
}

}  // namespace colmap_ext
