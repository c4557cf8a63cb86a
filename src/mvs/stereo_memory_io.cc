#include "colmap_ext/mvs/stereo_memory_io.h"

#include <algorithm>
#include <array>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mvs/mesh_bytes.h"

namespace colmap_ext {
namespace {

constexpr const char* kFormat = "colmap_ext settled photos 1";

void Put(const PinholeCamera& camera, std::ostream& out) {
  WriteBytes(out, camera.width);
  WriteBytes(out, camera.height);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) WriteBytes(out, value);
}

PinholeCamera TakeCamera(ByteReader* in) {
  PinholeCamera camera;
  camera.width = in->Read<int>("camera");
  camera.height = in->Read<int>("camera");
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    *value = in->Read<double>("camera");
  }
  if (camera.width <= 0 || camera.height <= 0 || !(camera.fx > 0 && camera.fy > 0)) {
    in->Fail("a camera without size or focal length");
  }
  return camera;
}

void Put(const Camera& lens, std::ostream& out) {
  WriteBytes(out, static_cast<int>(lens.model));
  WriteBytes(out, lens.width);
  WriteBytes(out, lens.height);
  PutBytes(lens.params, out);
}

Camera TakeLens(ByteReader* in) {
  Camera lens;
  const CameraModelInfo& info = GetCameraModelInfo(in->Read<int>("lens"));
  lens.model = info.model;
  lens.width = in->Read<int>("lens");
  lens.height = in->Read<int>("lens");
  TakeBytes(in, &lens.params);
  if (lens.width > 0 && lens.params.size() != static_cast<std::size_t>(info.num_params)) {
    in->Fail("a lens with too few or too many parameters");
  }
  return lens;
}

void Put(const Rigid3d& pose, std::ostream& out) {
  for (int k = 0; k < 4; ++k) WriteBytes(out, pose.rotation.coeffs()[k]);
  for (int k = 0; k < 3; ++k) WriteBytes(out, pose.translation[k]);
}

Rigid3d TakePose(ByteReader* in) {
  Rigid3d pose;
  for (int k = 0; k < 4; ++k) pose.rotation.coeffs()[k] = in->Read<double>("pose");
  for (int k = 0; k < 3; ++k) pose.translation[k] = in->Read<double>("pose");
  if (!pose.rotation.coeffs().allFinite() || !pose.translation.allFinite()) {
    in->Fail("a pose that is no number");
  }
  return pose;
}

void Put(const std::vector<PointSample>& samples, std::ostream& out) {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<int> triangles;
  std::vector<std::array<std::uint8_t, 3>> colors;
  for (const PointSample& sample : samples) {
    pixels.push_back(sample.pixel);
    triangles.push_back(sample.triangle);
    colors.push_back(sample.color);
  }
  PutBytes(pixels, out);
  PutBytes(triangles, out);
  PutBytes(colors, out);
}

std::vector<PointSample> TakeSamples(ByteReader* in) {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<int> triangles;
  std::vector<std::array<std::uint8_t, 3>> colors;
  TakeBytes(in, &pixels);
  TakeBytes(in, &triangles);
  TakeBytes(in, &colors);
  if (triangles.size() != pixels.size() || colors.size() != pixels.size()) {
    in->Fail("samples of different numbers");
  }
  std::vector<PointSample> samples(pixels.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] = {pixels[k], triangles[k], colors[k]};
  }
  return samples;
}

template <typename T>
bool AreFinite(const std::vector<T>& values) {
  return std::ranges::all_of(values, [](const T& value) { return value.allFinite(); });
}

// `low` ≤ every corner < `end`.
bool AreWithin(const std::vector<Eigen::Vector3i>& values, int low, std::size_t end) {
  return std::ranges::all_of(values, [&](const Eigen::Vector3i& corners) {
    return corners.minCoeff() >= low && corners.maxCoeff() < static_cast<int>(end);
  });
}

void CheckMesh(const SettledPhoto& settled, const ByteReader& in) {
  const ImageMesh& image = settled.view.image;
  const std::size_t triangles = image.triangles.size();
  const bool fits =
      image.neighbors.size() == triangles && image.superpixel.size() == triangles &&
      image.mean_bgr.size() == triangles && settled.view.inverse_depth.size() == triangles &&
      settled.view.confidence.size() == triangles && settled.view.supported.size() == triangles;
  const auto is_superpixel = [&](int s) { return s >= 0 && s < image.num_superpixels; };
  const auto is_sample = [&](const PointSample& sample) {
    return sample.triangle >= 0 && static_cast<std::size_t>(sample.triangle) < triangles &&
           sample.pixel.allFinite();
  };
  if (!fits || !AreWithin(image.triangles, 0, image.vertices_px.size()) ||
      !AreWithin(image.neighbors, -1, triangles) ||
      !std::ranges::all_of(image.superpixel, is_superpixel) ||
      !std::ranges::all_of(settled.samples, is_sample)) {
    in.Fail("triangles that do not fit together");
  }
  if (!AreFinite(image.vertices_px) || !AreFinite(settled.view.inverse_depth)) {
    in.Fail("a mesh that is no numbers");
  }
}

void Put(const SettledPhoto& settled, std::ostream& out) {
  WriteBytes(out, settled.stereo_key);
  WriteBytes(out, settled.partition_key);
  Put(settled.lens, out);
  Put(settled.view.camera, out);
  Put(settled.view.cam_from_world, out);
  PutBytes(settled.view.image, out);
  PutBytes(settled.view.inverse_depth, out);
  PutBytes(settled.view.confidence, out);
  PutBytes(settled.view.supported, out);
  WriteBytes(out, std::uint64_t{settled.neighbors.size()});
  for (const SettledPhoto::Neighbor& neighbor : settled.neighbors) {
    out << neighbor.name << '\0';
    Put(neighbor.camera, out);
    Put(neighbor.cam_from_world, out);
  }
  WriteBytes(out, settled.num_points);
  WriteBytes(out, settled.sampler_key);
  Put(settled.samples, out);
}

SettledPhoto TakePhoto(ByteReader* in) {
  SettledPhoto settled;
  settled.stereo_key = in->Read<std::uint64_t>("options");
  settled.partition_key = in->Read<std::uint64_t>("pixels");
  settled.lens = TakeLens(in);
  settled.view.camera = TakeCamera(in);
  settled.view.cam_from_world = TakePose(in);
  TakeBytes(in, &settled.view.image);
  TakeBytes(in, &settled.view.inverse_depth);
  TakeBytes(in, &settled.view.confidence);
  TakeBytes(in, &settled.view.supported);
  constexpr std::size_t kLeastNeighborBytes = 97;
  settled.neighbors.resize(in->ReadCount(kLeastNeighborBytes, "neighbours"));
  for (SettledPhoto::Neighbor& neighbor : settled.neighbors) {
    neighbor.name = in->ReadCString("neighbour");
    neighbor.camera = TakeCamera(in);
    neighbor.cam_from_world = TakePose(in);
  }
  settled.num_points = in->Read<std::uint64_t>("points");
  settled.sampler_key = in->Read<std::uint64_t>("options");
  settled.samples = TakeSamples(in);
  CheckMesh(settled, *in);
  return settled;
}

void TakePhotos(ByteReader* in, StereoMemory* memory) {
  if (in->ReadCString("format") != kFormat) in->Fail("not a file of this program's version");
  constexpr std::size_t kLeastPhotoBytes = 249;
  const std::size_t count = in->ReadCount(kLeastPhotoBytes, "photos");
  for (std::size_t k = 0; k < count; ++k) {
    const std::string name = in->ReadCString("photo");
    memory->photo.emplace(name, TakePhoto(in));
  }
  in->ExpectEnd();
}

}  // namespace

void WriteStereoMemory(const StereoMemory& memory, const std::set<std::string>& names,
                       const std::filesystem::path& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << kFormat << '\0';
    WriteBytes(out, std::uint64_t{names.size()});
    for (const std::string& name : names) {
      out << name << '\0';
      Put(memory.photo.at(name), out);
    }
  });
}

void ReadStereoMemory(const std::filesystem::path& path, StereoMemory* memory) {
  RequireFile(path, "meshes of photos");
  try {
    ByteReader in(path);
    TakePhotos(&in, memory);
  } catch (const Error& error) {
    throw Error(std::string(error.what()) + "; or remove it, and its photos are solved again");
  }
}

}  // namespace colmap_ext
