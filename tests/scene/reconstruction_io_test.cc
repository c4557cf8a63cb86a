#include "colmap_ext/scene/reconstruction_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/sparse_model.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
// Bit for bit: what comes back from a file is what went in.
// COLMAP normalises rotations again, which may change their last bit.
void ExpectSame(const Reconstruction& a, const Reconstruction& b, double rotation_tolerance = 0) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (const auto& [id, camera] : a.cameras) {
    const Camera& other = b.cameras.at(id);
    EXPECT_EQ(camera.model, other.model);
    EXPECT_EQ(camera.width, other.width);
    EXPECT_EQ(camera.height, other.height);
    EXPECT_EQ(camera.params, other.params);
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (const auto& [id, image] : a.images) {
    const SparseImage& other = b.images.at(id);
    EXPECT_EQ(image.name, other.name);
    EXPECT_EQ(image.camera_id, other.camera_id);
    const Eigen::Vector4d difference =
        image.cam_from_world.rotation.coeffs() - other.cam_from_world.rotation.coeffs();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), rotation_tolerance);
    EXPECT_EQ(image.cam_from_world.translation, other.cam_from_world.translation);
    ASSERT_EQ(image.keypoints.size(), other.keypoints.size());
    for (std::size_t i = 0; i < image.keypoints.size(); ++i) {
      EXPECT_EQ(image.keypoints[i].pixel, other.keypoints[i].pixel);
      EXPECT_EQ(image.keypoints[i].point3D_id, other.keypoints[i].point3D_id);
    }
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (const auto& [id, point] : a.points) {
    const SparsePoint& other = b.points.at(id);
    EXPECT_EQ(point.position, other.position);
    EXPECT_EQ(point.color, other.color);
    EXPECT_EQ(point.error_px, other.error_px);
    ASSERT_EQ(point.track.size(), other.track.size());
    for (std::size_t i = 0; i < point.track.size(); ++i) {
      EXPECT_EQ(point.track[i].image_id, other.track[i].image_id);
      EXPECT_EQ(point.track[i].keypoint_index, other.track[i].keypoint_index);
    }
  }
}

void WriteRaw(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

// Overwrites bytes of a file.
template <typename T>
void Patch(const fs::path& path, std::size_t offset, T value) {
  std::string content = ReadFile(path);
  ASSERT_LE(offset + sizeof(T), content.size());
  std::memcpy(content.data() + offset, &value, sizeof(T));
  WriteRaw(path, content);
}

TEST(ReconstructionIO, BinaryComesBackBitForBit) {
  TestFolder folder;
  const Reconstruction model = MakeSparseModel();
  WriteReconstructionBinary(model, folder / "new/sparse");
  ExpectSame(model, ReadReconstruction(folder / "new/sparse"));
}

TEST(ReconstructionIO, TextComesBackBitForBit) {
  TestFolder folder;
  Reconstruction model = MakeSparseModel();
  model.images.begin()->second.name = "name with  blanks.jpg";
  model.images.rbegin()->second.cam_from_world.translation.x() = 1.0 / 3 * 1e-300;
  WriteReconstructionText(model, folder / "new/sparse");
  ExpectSame(model, ReadReconstruction(folder / "new/sparse"));
}

TEST(ReconstructionIO, EmptyModelComesBack) {
  TestFolder folder;
  WriteReconstructionBinary({}, folder / "bin");
  WriteReconstructionText({}, folder / "txt");
  ExpectSame({}, ReadReconstruction(folder / "bin"));
  ExpectSame({}, ReadReconstruction(folder / "txt"));
}

TEST(ReconstructionIO, ImagesWithoutKeypointsComeBack) {
  TestFolder folder;
  Reconstruction model = MakeSparseModel();
  model.points.clear();
  for (auto& [id, image] : model.images) image.keypoints.clear();
  WriteReconstructionBinary(model, folder / "bin");
  WriteReconstructionText(model, folder / "txt");
  ExpectSame(model, ReadReconstruction(folder / "bin"));
  ExpectSame(model, ReadReconstruction(folder / "txt"));
}

TEST(ReconstructionIO, InconsistentModelIsNotWritten) {
  TestFolder folder;
  Reconstruction model = MakeSparseModel();
  model.cameras.erase(1);
  EXPECT_ERROR_HAS(WriteReconstructionBinary(model, folder / "bin"), "camera 1");
  EXPECT_ERROR_HAS(WriteReconstructionText(model, folder / "txt"), "camera 1");
  EXPECT_FALSE(fs::exists(folder / "bin"));
  EXPECT_FALSE(fs::exists(folder / "txt"));
}

TEST(ReconstructionIO, MissingFolderAndMissingFilesAreNamed) {
  TestFolder folder;
  EXPECT_ERROR_HAS(ReadReconstruction(folder / "nowhere"), (folder / "nowhere").string());
  EXPECT_ERROR_HAS(ReadReconstruction(folder.path()), "holds no sparse model");
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    WriteReconstructionBinary(MakeSparseModel(), folder / "model");
    fs::remove(folder / "model" / name);
    const std::string part = std::string(name) == "cameras.bin" ? "holds no sparse model" : name;
    EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), part);
  }
}

TEST(ReconstructionIO, FilesThatWouldBePreferredAreNotLeftBesideAModel) {
  TestFolder folder;
  WriteReconstructionBinary(MakeSparseModel(), folder / "a");
  EXPECT_ERROR_HAS(WriteReconstructionText(MakeSparseModel(), folder / "a"), "cameras.bin");
  WriteRaw(folder / "a/frames.bin", "");
  EXPECT_ERROR_HAS(WriteReconstructionBinary(MakeSparseModel(), folder / "a"), "frames.bin");
}

class TruncatedModel : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(ReconstructionIO, TruncatedModel,
                         testing::Values("cameras.bin", "images.bin", "points3D.bin", "cameras.txt",
                                         "images.txt", "points3D.txt"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST_P(TruncatedModel, IsAnErrorAtEveryByteAndNamesTheModel) {
  TestFolder folder;
  const std::string name = GetParam();
  const bool is_binary = name.ends_with(".bin");
  if (is_binary) {
    WriteReconstructionBinary(MakeSparseModel(11, 11), folder / "model");
  } else {
    WriteReconstructionText(MakeSparseModel(11, 11), folder / "model");
  }
  ASSERT_NO_THROW(ReadReconstruction(folder / "model"));
  const fs::path path = folder / "model" / name;
  const std::string content = ReadFile(path);
  // From the end, so that each step only cuts the file.
  for (std::size_t size = content.size(); size-- > 0;) {
    fs::resize_file(path, size);
    const std::string message = ErrorOf([&] { ReadReconstruction(folder / "model"); });
    EXPECT_HAS(message, (folder / "model").string()) << size;
  }
  WriteRaw(path, content + "\xff");
  EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), name);
}

TEST_P(TruncatedModel, DamagedBytesNeverCrash) {
  // Any byte may be wrong: the reader answers with a model that passes CheckConsistency or an
  // Error.
  TestFolder folder;
  const std::string name = GetParam();
  if (name.ends_with(".bin")) {
    WriteReconstructionBinary(MakeSparseModel(11, 11), folder / "model");
  } else {
    WriteReconstructionText(MakeSparseModel(11, 11), folder / "model");
  }
  const fs::path path = folder / "model" / name;
  const std::string content = ReadFile(path);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const auto offset = static_cast<std::streamoff>(random() % content.size());
    file.seekp(offset).put(static_cast<char>(random())).flush();
    try {
      CheckConsistency(ReadReconstruction(folder / "model"), "model");
    } catch (const Error& error) {
      EXPECT_HAS(error.what(), (folder / "model").string());
    }
    file.seekp(offset).put(content[static_cast<std::size_t>(offset)]).flush();
  }
  ASSERT_TRUE(file.good());
  EXPECT_NO_THROW(ReadReconstruction(folder / "model"));
}

TEST(ReconstructionIO, HugeCountsAreErrorsAtTheirByte) {
  TestFolder folder;
  const auto expect_error = [&](const char* file, std::size_t offset, const char* what) {
    WriteReconstructionBinary(MakeSparseModel(), folder / "model");
    Patch<std::uint64_t>(folder / "model" / file, offset, std::uint64_t{1} << 61);
    const std::string message = ErrorOf([&] { ReadReconstruction(folder / "model"); });
    EXPECT_HAS(message, std::string(file) + ": byte " + std::to_string(offset));
    EXPECT_HAS(message, what);
  };
  expect_error("cameras.bin", 0, "the number of cameras");
  expect_error("images.bin", 0, "the number of images");
  const std::size_t name_size = MakeSparseModel().images.begin()->second.name.size() + 1;
  expect_error("images.bin", 8 + 4 + 56 + 4 + name_size, "number of keypoints");
  expect_error("points3D.bin", 0, "the number of points");
  expect_error("points3D.bin", 8 + 8 + 24 + 3 + 8, "track length");
}

TEST(ReconstructionIO, CountSmallerThanTheRecordsIsAnError) {
  TestFolder folder;
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) {
    WriteReconstructionBinary(MakeSparseModel(), folder / "model");
    Patch<std::uint64_t>(folder / "model" / file, 0, 1);
    EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), "follow the last record");
  }
}

TEST(ReconstructionIO, UnknownCameraModelIsNamedWithItsFile) {
  TestFolder folder;
  WriteReconstructionBinary(MakeSparseModel(), folder / "model");
  Patch<std::int32_t>(folder / "model/cameras.bin", 8 + 4, 17);
  const std::string message = ErrorOf([&] { ReadReconstruction(folder / "model"); });
  EXPECT_HAS(message, "cameras.bin");
  EXPECT_HAS(message, "unknown camera model id 17");
}

TEST(ReconstructionIO, AbsurdImageSizeIsAnError) {
  TestFolder folder;
  for (const std::uint64_t side : {std::uint64_t{0}, std::uint64_t{1} << 40}) {
    WriteReconstructionBinary(MakeSparseModel(), folder / "model");
    Patch<std::uint64_t>(folder / "model/cameras.bin", 8 + 4 + 4, side);
    EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), "a camera's width");
  }
}

TEST(ReconstructionIO, SameIdTwiceIsAnError) {
  TestFolder folder;
  WriteReconstructionBinary(MakeSparseModel(), folder / "model");
  // The second camera (after a SIMPLE_PINHOLE with three parameters) gets the id of the first.
  Patch<std::uint32_t>(folder / "model/cameras.bin", 8 + 24 + 24, 1);
  EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), "camera 1 is there twice");
}

// A text model of one image whose files are given.
void WriteTextModel(const fs::path& folder, const std::string& cameras, const std::string& images,
                    const std::string& points) {
  fs::create_directories(folder);
  WriteRaw(folder / "cameras.txt", cameras);
  WriteRaw(folder / "images.txt", images);
  WriteRaw(folder / "points3D.txt", points);
}

constexpr char kCameras[] = "# comment\n\n1 PINHOLE 640 480 500 500 320 240\n";
constexpr char kImages[] = "2 1 0 0 0 1 2 3 1 a.jpg\n10 20 7 30 40 -1\n";
constexpr char kPoints[] = "7 1 2 3 255 128 0 0.5 2 0\n";

TEST(ReconstructionText, HandWrittenModelIsRead) {
  TestFolder folder;
  WriteTextModel(folder.path(), kCameras, kImages, kPoints);
  const Reconstruction model = ReadReconstruction(folder.path());
  EXPECT_EQ(model.cameras.at(1).params, (std::vector<double>{500, 500, 320, 240}));
  const SparseImage& image = model.images.at(2);
  EXPECT_EQ(image.name, "a.jpg");
  EXPECT_EQ(image.cam_from_world.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(image.keypoints[0].pixel, Eigen::Vector2d(10, 20));
  EXPECT_EQ(image.keypoints[0].point3D_id, 7u);
  EXPECT_EQ(image.keypoints[1].point3D_id, kInvalidPoint3DId);
  EXPECT_EQ(model.points.at(7).color[1], 128);
}

TEST(ReconstructionText, WindowsLineEndsAndTabsAreRead) {
  TestFolder folder;
  WriteTextModel(folder.path(), "1\tPINHOLE\t640 480 500 500 320 240\r\n",
                 "2 1 0 0 0 1 2 3 1 a b.jpg \r\n\r\n", "# none\r\n");
  EXPECT_EQ(ReadReconstruction(folder.path()).images.at(2).name, "a b.jpg");
}

TEST(ReconstructionText, RotationIsNormalised) {
  TestFolder folder;
  WriteTextModel(folder.path(), kCameras, "2 2 0 0 0 1 2 3 1 a.jpg\n\n", "#\n");
  EXPECT_EQ(ReadReconstruction(folder.path()).images.at(2).cam_from_world.rotation.w(), 1);
  WriteTextModel(folder.path(), kCameras, "2 0 0 0 0 1 2 3 1 a.jpg\n\n", "#\n");
  EXPECT_ERROR_HAS(ReadReconstruction(folder.path()), "a.jpg");
}

struct BadText {
  const char* name;
  const char* cameras;
  const char* images;
  const char* points;
  const char* message;  // begins with file and line
};

const BadText kBadTexts[] = {
    {"CameraModel", "# c\n1 PINHOLE9 640 480 500 500 320 240\n", kImages, kPoints,
     "cameras.txt: line 2: unknown camera model 'PINHOLE9'"},
    {"TooFewParams", "1 PINHOLE 640 480 500 500 320\n", kImages, kPoints,
     "cameras.txt: line 1: camera model PINHOLE has 4 parameters, the line has 3"},
    {"TooManyParams", "1 PINHOLE 640 480 500 500 320 240 9\n", kImages, kPoints,
     "cameras.txt: line 1: camera model PINHOLE has 4 parameters, the line has 5"},
    {"ParamNotANumber", "1 PINHOLE 640 480 500 5o0 320 240\n", kImages, kPoints,
     "cameras.txt: line 1: '5o0' is not a valid number for PARAMS[]"},
    {"NegativeWidth", "1 PINHOLE -640 480 500 500 320 240\n", kImages, kPoints,
     "cameras.txt: line 1: '-640' is not a valid number for WIDTH"},
    {"CameraTwice", "1 PINHOLE 640 480 500 500 320 240\n1 PINHOLE 640 480 500 500 320 240\n",
     kImages, kPoints, "cameras.txt: line 2: camera 1 is there twice"},
    {"ImageWithoutName", kCameras, "2 1 0 0 0 1 2 3 1\n10 20 7\n", kPoints,
     "images.txt: line 1: there is no column for NAME"},
    {"ImageWithShortPose", kCameras, "2 1 0 0 0 1 2\n\n", kPoints,
     "images.txt: line 1: there is no column for TX, TY, TZ"},
    {"ImageIdNegative", kCameras, "-2 1 0 0 0 1 2 3 1 a.jpg\n\n", kPoints,
     "images.txt: line 1: '-2' is not a valid number for IMAGE_ID"},
    {"TwoColumnsOfKeypoint", kCameras, "2 1 0 0 0 1 2 3 1 a.jpg\n10 20 7 30 40\n", kPoints,
     "images.txt: line 2: the number of columns is not a multiple of 3"},
    {"KeypointNotANumber", kCameras, "2 1 0 0 0 1 2 3 1 a.jpg\n10 2x 7\n", kPoints,
     "images.txt: line 2: '2x' is not a valid number for Y"},
    {"NoKeypointLine", kCameras, "# c\n2 1 0 0 0 1 2 3 1 a.jpg\n", kPoints,
     "images.txt: line 2: image 'a.jpg' has no line of keypoints"},
    {"Colour", kCameras, kImages, "7 1 2 3 256 128 0 0.5 2 0\n",
     "points3D.txt: line 1: '256' is not a valid number for R, G, B"},
    {"OddTrack", kCameras, kImages, "# c\n7 1 2 3 255 128 0 0.5 2\n",
     "points3D.txt: line 2: there is no column for POINT2D_IDX"},
    {"ShortPoint", kCameras, kImages, "7 1 2 3 255\n",
     "points3D.txt: line 1: there is no column for R, G, B"},
    {"NanPoint", kCameras, kImages, "7 nan 2 3 255 128 0 0.5 2 0\n", "not a finite number"},
    {"NoLineEnd", kCameras, kImages, "7 1 2 3 255 128 0 0.5 2 0",
     "points3D.txt: does not end with a line end"},
    {"NotText",
     "\x7f"
     "ELF\x01\n",
     kImages, kPoints, "cameras.txt: line 1"},
};

class MalformedText : public testing::TestWithParam<BadText> {};
INSTANTIATE_TEST_SUITE_P(ReconstructionText, MalformedText, testing::ValuesIn(kBadTexts),
                         [](const auto& info) { return info.param.name; });

TEST_P(MalformedText, IsAnErrorThatNamesFileAndLine) {
  TestFolder folder;
  WriteTextModel(folder.path(), GetParam().cameras, GetParam().images, GetParam().points);
  EXPECT_ERROR_HAS(ReadReconstruction(folder.path()), GetParam().message);
}

// ---- With the real colmap.

TEST(ReconstructionWithColmap, OurBinaryThroughColmapsTextComesBack) {
  if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  TestFolder folder;
  const Reconstruction model = MakeSparseModel();
  WriteReconstructionBinary(model, folder / "ours");
  fs::create_directories(folder / "text");
  RunColmap({"model_converter", "--input_path", (folder / "ours").string(), "--output_path",
             (folder / "text").string(), "--output_type", "TXT"});
  ASSERT_TRUE(fs::exists(folder / "text/images.txt"));
  ExpectSame(model, ReadReconstruction(folder / "text"), 1e-15);
}

TEST(ReconstructionWithColmap, OurTextThroughColmapsBinaryComesBack) {
  if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  TestFolder folder;
  const Reconstruction model = MakeSparseModel();
  WriteReconstructionText(model, folder / "ours");
  fs::create_directories(folder / "binary");
  RunColmap({"model_converter", "--input_path", (folder / "ours").string(), "--output_path",
             (folder / "binary").string(), "--output_type", "BIN"});
  ASSERT_TRUE(fs::exists(folder / "binary/images.bin"));
  ExpectSame(model, ReadReconstruction(folder / "binary"), 1e-15);
}

TEST(ReconstructionWithColmap, OurBinaryAndColmapsAreTheSameRecords) {
  if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  TestFolder folder;
  WriteReconstructionBinary(MakeSparseModel(), folder / "ours");
  fs::create_directories(folder / "theirs");
  RunColmap({"model_converter", "--input_path", (folder / "ours").string(), "--output_path",
             (folder / "theirs").string(), "--output_type", "BIN"});
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    EXPECT_EQ(fs::file_size(folder / "ours" / name), fs::file_size(folder / "theirs" / name));
  }
  ExpectSame(ReadReconstruction(folder / "ours"), ReadReconstruction(folder / "theirs"), 1e-15);
}

TEST(ReconstructionWithColmap, TransformAgreesWithModelTransformer) {
  if (!HasColmap()) GTEST_SKIP() << "colmap is not on the PATH";
  TestFolder folder;
  Reconstruction model = MakeSparseModel();
  WriteReconstructionBinary(model, folder / "ours");
  fs::create_directories(folder / "theirs");
  // 4x4 row by row: scale 2, a quarter turn about z.
  WriteRaw(folder / "transform.txt", "0 -2 0 5\n2 0 0 6\n0 0 2 7\n0 0 0 1\n");
  RunColmap({"model_transformer", "--input_path", (folder / "ours").string(), "--output_path",
             (folder / "theirs").string(), "--transform_path",
             (folder / "transform.txt").string()});
  Sim3d new_from_old;
  new_from_old.scale = 2;
  new_from_old.rotation = Eigen::Quaterniond(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  new_from_old.translation = {5, 6, 7};
  TransformReconstruction(new_from_old, &model);
  const Reconstruction theirs = ReadReconstruction(folder / "theirs");
  for (const auto& [id, image] : model.images) {
    const Rigid3d& pose = theirs.images.at(id).cam_from_world;
    EXPECT_LT((CameraCenter(image.cam_from_world) - CameraCenter(pose)).norm(), 1e-9);
    EXPECT_LT(image.cam_from_world.rotation.angularDistance(pose.rotation), 1e-7);
  }
  for (const auto& [id, point] : model.points) {
    EXPECT_LT((theirs.points.at(id).position - point.position).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace colmap_ext
