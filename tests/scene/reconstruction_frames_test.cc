// Rigs and frames of models: COLMAP 3.12 and later.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/sparse_model.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// A model of three photos, cameras 1, 3 and 5, with a frame each, as the mapper of 4.x writes it.
Reconstruction ModelWithFrames() {
  Reconstruction model = MakeSparseModel(3, 9);
  while (model.cameras.size() > 3) model.cameras.erase(std::prev(model.cameras.end()));
  model.frame_table = FrameTableOf(model);
  return model;
}

// Photos 2 and 5 are one frame of a rig: camera 3 stands at its place beside camera 1.
Reconstruction ModelWithStereoRig() {
  Reconstruction model = ModelWithFrames();
  const Rigid3d right_from_left{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {0.5, 0.01, -0.02}};
  const SensorId left{SensorType::kCamera, 1}, right{SensorType::kCamera, 3};
  model.images.at(5).cam_from_world = right_from_left * model.images.at(2).cam_from_world;
  FrameTable table;
  table.rigs[4] = {left, {{right, right_from_left}, {{SensorType::kImu, 8}, std::nullopt}}};
  table.rigs[9] = {{SensorType::kCamera, 5}, {}};
  table.frames[70] = {4, {{left, 2}, {right, 5}, {{SensorType::kImu, 8}, 1000}}};
  table.frames[71] = {9, {{{SensorType::kCamera, 5}, 8}}};
  model.frame_table = table;
  return model;
}

void ExpectSameTable(const FrameTable& a, const FrameTable& b) {
  ASSERT_EQ(a.rigs.size(), b.rigs.size());
  for (const auto& [id, rig] : a.rigs) {
    const Rig& other = b.rigs.at(id);
    EXPECT_EQ(rig.reference, other.reference);
    ASSERT_EQ(rig.sensor_from_rig.size(), other.sensor_from_rig.size());
    for (const auto& [sensor, pose] : rig.sensor_from_rig) {
      const auto& other_pose = other.sensor_from_rig.at(sensor);
      ASSERT_EQ(pose.has_value(), other_pose.has_value());
      if (!pose) continue;
      EXPECT_EQ(pose->rotation.coeffs(), other_pose->rotation.coeffs());
      EXPECT_EQ(pose->translation, other_pose->translation);
    }
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (const auto& [id, frame] : a.frames) {
    const Frame& other = b.frames.at(id);
    EXPECT_EQ(frame.rig_id, other.rig_id);
    ASSERT_EQ(frame.data.size(), other.data.size());
    for (std::size_t i = 0; i < frame.data.size(); ++i) {
      EXPECT_EQ(frame.data[i].sensor, other.data[i].sensor);
      EXPECT_EQ(frame.data[i].id, other.data[i].id);
    }
  }
}

std::string Hex(const std::string& bytes) {
  std::string text;
  for (const char c : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof(digits), "%02x", static_cast<unsigned char>(c));
    text += digits;
  }
  return text;
}

TEST(FrameTable, ComesBackFromBinaryAndText) {
  TestFolder folder;
  for (const Reconstruction& model : {ModelWithFrames(), ModelWithStereoRig()}) {
    const fs::path binary = folder / ("bin" + std::to_string(model.frame_table.rigs.size()));
    const fs::path text = folder / ("txt" + std::to_string(model.frame_table.rigs.size()));
    WriteReconstructionBinary(model, binary);
    WriteReconstructionText(model, text);
    ExpectSameTable(model.frame_table, ReadReconstruction(binary).frame_table);
    ExpectSameTable(model.frame_table, ReadReconstruction(text).frame_table);
    for (const auto& [id, image] : model.images) {
      EXPECT_EQ(ReadReconstruction(binary).images.at(id).cam_from_world.translation,
                image.cam_from_world.translation);
    }
  }
}

TEST(FrameTable, FilesAreThoseOfColmap42) {
  TestFolder folder;
  Reconstruction model = ModelWithFrames();
  model.images.erase(model.images.find(5), model.images.end());
  model.points.clear();
  model.images.at(2).keypoints.clear();
  model.images.at(2).cam_from_world = {Eigen::Quaterniond(1, 0, 0, 0), {1, 2, -2}};
  model.frame_table = {};
  model.frame_table = FrameTableOf(model);
  WriteReconstructionBinary(model, folder / "bin");
  // Number of rigs (u64), id, number of sensors (u32), type and id of the reference sensor.
  EXPECT_EQ(Hex(ReadFile(folder / "bin/rigs.bin")),
            "0100000000000000"
            "01000000"
            "01000000"
            "00000000"
            "01000000");
  // Number of frames, id, rig, rotation w x y z, translation, number of data, type, sensor, id.
  EXPECT_EQ(Hex(ReadFile(folder / "bin/frames.bin")),
            "0100000000000000"
            "02000000"
            "01000000"
            "000000000000f03f"
            "0000000000000000"
            "0000000000000000"
            "0000000000000000"
            "000000000000f03f"
            "0000000000000040"
            "00000000000000c0"
            "01000000"
            "00000000"
            "01000000"
            "0200000000000000");
  WriteReconstructionText(model, folder / "txt");
  EXPECT_HAS(ReadFile(folder / "txt/rigs.txt"), "\n1 1 CAMERA 1\n");
  EXPECT_HAS(ReadFile(folder / "txt/frames.txt"), "\n2 1 1 0 0 0 1 2 -2 1 CAMERA 1 2\n");
}

TEST(FrameTable, ModelsWithoutFramesGetNoFilesOfThem) {
  TestFolder folder;
  WriteReconstructionBinary(MakeSparseModel(), folder / "bin");
  EXPECT_FALSE(fs::exists(folder / "bin/rigs.bin"));
  EXPECT_FALSE(fs::exists(folder / "bin/frames.bin"));
  EXPECT_TRUE(ReadReconstruction(folder / "bin").frame_table.IsEmpty());
}

TEST(FrameTable, PhotosAreCompletedAndFramesWithoutPhotosLeftOut) {
  Reconstruction model = ModelWithStereoRig();
  model.frame_table.frames.erase(71);
  model.frame_table.frames[8] = {9, {{{SensorType::kCamera, 5}, 500}}};  // of no photo here
  model.frame_table.rigs.erase(9);
  model.frame_table.rigs[5] = {{SensorType::kCamera, 77}, {}};  // takes the id of camera 5
  model.frame_table.frames[8].rig_id = 5;
  model.frame_table.frames[8].data[0].sensor.id = 77;
  const FrameTable table = FrameTableOf(model);
  ASSERT_EQ(table.frames.size(), 2u);
  EXPECT_EQ(table.frames.at(8).data.at(0).id, 8u);
  EXPECT_EQ(table.frames.at(8).rig_id, 6u);
  EXPECT_EQ(table.rigs.at(6).reference, (SensorId{SensorType::kCamera, 5}));
  EXPECT_EQ(table.frames.at(70).data.size(), 3u);
  EXPECT_EQ(ProblemOf(table), "");
}

TEST(FrameTable, PosesOfFramesFollowThePhotos) {
  const Reconstruction model = ModelWithStereoRig();
  const Rigid3d pose = RigFromWorld(model, model.frame_table, 70);
  EXPECT_EQ(pose.translation, model.images.at(2).cam_from_world.translation);
  EXPECT_EQ(pose.rotation.coeffs(), model.images.at(2).cam_from_world.rotation.coeffs());
}

TEST(FrameTable, ARigGrowsWithItsModel) {
  TestFolder folder;
  Reconstruction model = ModelWithStereoRig();
  const Sim3d transform{2.5, Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {3, 4, 5}};
  TransformReconstruction(transform, &model);
  const auto& pose = model.frame_table.rigs.at(4).sensor_from_rig.at({SensorType::kCamera, 3});
  EXPECT_NEAR(pose->translation.x(), 1.25, 1e-12);
  EXPECT_NO_THROW(WriteReconstructionBinary(model, folder / "bin"));
  EXPECT_NO_THROW(ReadReconstruction(folder / "bin"));
}

TEST(FrameTable, PhotosThatLeftTheirRigAreAnErrorBeforeAnythingIsWritten) {
  TestFolder folder;
  Reconstruction model = ModelWithStereoRig();
  model.images.at(5).cam_from_world.translation.x() += 0.01;
  EXPECT_ERROR_HAS(WriteReconstructionBinary(model, folder / "bin"), "frame 70");
  EXPECT_ERROR_HAS(WriteReconstructionText(model, folder / "txt"), "rig 4");
  EXPECT_FALSE(fs::exists(folder / "bin/rigs.bin"));
  EXPECT_FALSE(fs::exists(folder / "bin/cameras.bin"));
  model.frame_table.frames.at(70).data.erase(model.frame_table.frames.at(70).data.begin());
  model.frame_table.rigs.at(4).sensor_from_rig.at({SensorType::kCamera, 3}) = std::nullopt;
  EXPECT_ERROR_HAS(WriteReconstructionBinary(model, folder / "bin"), "no photo of it has a known");
}

TEST(FrameTable, FramesThatSayOtherPosesThanThePhotosAreAnError) {
  TestFolder folder;
  Reconstruction model = ModelWithFrames();
  WriteReconstructionBinary(model, folder / "bin");
  model.images.at(2).cam_from_world.translation.x() += 0.01;
  WriteReconstructionBinary(model, folder / "other");
  fs::copy_file(folder / "other/frames.bin", folder / "bin/frames.bin",
                fs::copy_options::overwrite_existing);
  EXPECT_ERROR_HAS(ReadReconstruction(folder / "bin"), "frame 2 has another pose");
}

TEST(FrameTable, OneFileWithoutTheOtherIsAnError) {
  TestFolder folder;
  for (const char* name : {"rigs.bin", "frames.bin"}) {
    WriteReconstructionBinary(ModelWithFrames(), folder / name);
    fs::remove(folder / name / name);
    EXPECT_ERROR_HAS(ReadReconstruction(folder / name), name);
  }
}

TEST(FrameTable, ContradictionsAreErrors) {
  TestFolder folder;
  const auto error_of = [&](const std::function<void(FrameTable*)>& damage) {
    Reconstruction model = ModelWithFrames();
    damage(&model.frame_table);
    return ErrorOf([&] { WriteReconstructionBinary(model, folder / "bin"); });
  };
  EXPECT_HAS(error_of([](FrameTable* t) { t->frames.at(2).rig_id = 99; }), "frame 2 is of rig 99");
  EXPECT_HAS(error_of([](FrameTable* t) { t->frames.at(2).data[0].sensor.id = 99; }), "camera 99");
  EXPECT_HAS(error_of([](FrameTable* t) { t->frames[9] = t->frames.at(2); }), "in two frames");
  EXPECT_HAS(error_of([](FrameTable* t) { t->rigs[9] = t->rigs.at(1); }), "in two rigs");
  EXPECT_HAS(error_of([](FrameTable* t) { t->frames.at(2).data[0].id = 5; }), "photo");
}

class TruncatedFrames : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(FrameTable, TruncatedFrames,
                         testing::Values("rigs.bin", "frames.bin", "rigs.txt", "frames.txt"),
                         [](const auto& info) {
                           std::string name = info.param;
                           name[name.find('.')] = '_';
                           return name;
                         });

TEST_P(TruncatedFrames, IsAnErrorThatNamesTheFile) {
  TestFolder folder;
  const Reconstruction model = ModelWithStereoRig();
  if (std::string(GetParam()).ends_with("bin")) {
    WriteReconstructionBinary(model, folder / "model");
  } else {
    WriteReconstructionText(model, folder / "model");
  }
  const fs::path path = folder / "model" / GetParam();
  for (std::size_t size = fs::file_size(path) - 1; size > 0; --size) {
    fs::resize_file(path, size);
    const std::string content = ReadFile(path);
    // Text cut at the end of a line is a shorter table: its photos are completed.
    if (path.extension() == ".txt" && content.back() == '\n') continue;
    EXPECT_ERROR_HAS(ReadReconstruction(folder / "model"), GetParam());
  }
}

}  // namespace
}  // namespace colmap_ext
