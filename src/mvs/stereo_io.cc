#include "colmap_ext/mvs/stereo_io.h"

#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "colmap_ext/mvs/depth_map.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

// Keypoints as the ideal camera of `photo` sees them. Where the distortion cannot be undone, the
// image's corner stands in; no 3D point has such an observation.
void UndistortKeypoints(const Camera& camera, const PosedPhoto& photo, SparseImage* image) {
  for (Keypoint2D& keypoint : image->keypoints) {
    const auto normalized = NormalizedFromImage(camera, keypoint.pixel);
    keypoint.pixel = normalized ? photo.camera.Project(normalized->homogeneous())
                                : Eigen::Vector2d(Eigen::Vector2d::Zero());
  }
}

Reconstruction PinholeModel(const PhotoSet& photos, const Reconstruction& model) {
  Reconstruction pinhole = model;
  for (const PosedPhoto& photo : photos.photos) {
    const auto image = pinhole.images.find(photo.image_id);
    if (image == pinhole.images.end()) {
      throw Error("dense workspace: the sparse model has no photo " + photo.name);
    }
    const CameraId camera_id = image->second.camera_id;
    UndistortKeypoints(model.cameras.at(camera_id), photo, &image->second);
    pinhole.cameras[camera_id] = ToCamera(photo.camera);
  }
  return pinhole;
}

std::string FusionConfig(const PhotoSet& photos) {
  std::ostringstream text;
  for (const PosedPhoto& photo : photos.photos) text << photo.name << '\n';
  return text.str();
}

std::string PatchMatchConfig(const PhotoSet& photos,
                             const std::vector<std::vector<int>>& neighbors) {
  std::ostringstream text;
  for (std::size_t i = 0; i < photos.photos.size(); ++i) {
    if (neighbors[i].empty()) continue;
    text << photos.photos[i].name << '\n';
    for (std::size_t n = 0; n < neighbors[i].size(); ++n) {
      text << (n == 0 ? "" : ", ") << photos.photos[static_cast<std::size_t>(neighbors[i][n])].name;
    }
    text << '\n';
  }
  return text.str();
}

// The columns of a mesh's PLY file.
class ViewMeshPly {
 public:
  ViewMeshPly() {
    for (const char* name : {"x", "y", "z"}) Column(name, PlyType::kFloat64);
    for (const char* name : {"nx", "ny", "nz"}) Column(name, PlyType::kFloat32);
    for (const char* name : {"red", "green", "blue"}) Column(name, PlyType::kUInt8);
    Column("depth", PlyType::kFloat32);
    Column("confidence", PlyType::kFloat32);
    corners_.name = "vertex_indices";
  }

  void Add(const ViewMesh& view, double min_confidence) {
    for (std::size_t t = 0; t < view.image.triangles.size(); ++t) {
      if (view.supported[t] != 0 && view.confidence[t] >= min_confidence) AddFacet(view, t);
    }
  }

  void Write(const std::filesystem::path& path) {
    vertices_.name = "vertex";
    vertices_.count = vertices_.scalars[0].values.size();
    PlyElement faces;
    faces.name = "face";
    faces.count = corners_.NumRows();
    faces.lists.push_back(corners_);
    WritePly({{}, {vertices_, faces}}, path);
  }

 private:
  void Column(const char* name, PlyType type) { vertices_.scalars.push_back({name, type, {}}); }

  void AddFacet(const ViewMesh& view, std::size_t t) {
    const double first = static_cast<double>(vertices_.scalars[0].values.size());
    const Eigen::Vector3d normal = TriangleNormalInWorld(view, static_cast<int>(t));
    const Eigen::Vector3f rgb = view.image.mean_bgr[t].reverse();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d corner = CornerInWorld(view, static_cast<int>(t), k);
      std::size_t column = 0;
      for (int c = 0; c < 3; ++c) vertices_.scalars[column++].values.push_back(corner[c]);
      for (int c = 0; c < 3; ++c) vertices_.scalars[column++].values.push_back(normal[c]);
      for (int c = 0; c < 3; ++c) {
        vertices_.scalars[column++].values.push_back(cv::saturate_cast<std::uint8_t>(rgb[c]));
      }
      vertices_.scalars[column++].values.push_back(1.0 / view.inverse_depth[t][k]);
      vertices_.scalars[column++].values.push_back(static_cast<double>(view.confidence[t]));
    }
    // Positive area in the image (y down) is clockwise for the camera.
    for (const double corner : {first, first + 2, first + 1}) corners_.items.push_back(corner);
    corners_.starts.push_back(corners_.items.size());
  }

  PlyElement vertices_;
  PlyList corners_;
};

}  // namespace

ColoredMesh MeshInWorld(const ViewMesh& mesh, double min_confidence) {
  ColoredMesh result;
  for (std::size_t t = 0; t < mesh.image.triangles.size(); ++t) {
    if (mesh.supported[t] == 0 || mesh.confidence[t] < min_confidence) continue;
    const int first = static_cast<int>(result.mesh.vertices.size());
    for (int k = 0; k < 3; ++k) {
      result.mesh.vertices.push_back(CornerInWorld(mesh, static_cast<int>(t), k));
      result.color.push_back(mesh.image.mean_bgr[t].reverse().cast<double>() / 255.0);
    }
    // Positive area in the image (y down) is clockwise for the camera.
    result.mesh.faces.emplace_back(first, first + 2, first + 1);
  }
  return result;
}

void WriteViewMeshes(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                     double min_confidence, const std::filesystem::path& folder,
                     const JobRank& rank) {
  ParallelFor(views.size(), [&](std::size_t i) {
    if (!rank.IsMine(i)) return;
    ViewMeshPly ply;
    ply.Add(views[i], min_confidence);
    ply.Write(folder / (photos.photos[i].name + ".ply"));
  });
}

void WriteFusedMesh(const std::vector<ViewMesh>& views, double min_confidence,
                    const std::filesystem::path& path) {
  ViewMeshPly ply;
  for (const ViewMesh& view : views) ply.Add(view, min_confidence);
  ply.Write(path);
}

void WriteDenseWorkspace(const PhotoSet& photos, const Reconstruction& model,
                         const std::vector<ViewMesh>& views,
                         const std::vector<std::vector<int>>& neighbors, double min_confidence,
                         const std::filesystem::path& folder, const JobRank& rank) {
  const std::filesystem::path stereo = folder / "stereo";
  ParallelFor(views.size(), [&](std::size_t i) {
    if (!rank.IsMine(i)) return;
    const PosedPhoto& photo = photos.photos[i];
    const ViewMaps maps = RasterizeView(views[i], min_confidence);
    WriteDenseMap(maps.depth, stereo / "depth_maps" / (photo.name + ".geometric.bin"));
    WriteDenseMap(maps.normal, stereo / "normal_maps" / (photo.name + ".geometric.bin"));
    WriteDenseMap(maps.confidence, stereo / "confidence_maps" / (photo.name + ".bin"));
    WritePhoto(photo.bgr, folder / "images" / photo.name);
  });
  if (!rank.IsFirst()) return;
  WriteReconstructionBinary(PinholeModel(photos, model), folder / "sparse");
  WriteFileAtomically(stereo / "patch-match.cfg", PatchMatchConfig(photos, neighbors));
  WriteFileAtomically(stereo / "fusion.cfg", FusionConfig(photos));
}

}  // namespace colmap_ext
