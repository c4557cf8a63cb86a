// The whole stage with the real `colmap` on small photos with exact poses.
#include "colmap_ext/sfm/sparse_update.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "sfm/textured_photos.h"
#include "sfm/update_lock.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using testing_support::ArcName;
using testing_support::ArcPose;
using testing_support::WriteArcPhotos;

class SparseUpdate : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("sparse_update_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "images");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path images() const { return folder_ / "images"; }

  SparseUpdateInput Input(const std::string& name = "first") const {
    SparseUpdateInput input;
    input.image_path = images();
    input.database_path = folder_ / (name + ".db");
    input.work_path = folder_ / (name + "_work");
    return input;
  }

  std::string MessageOf(const SparseUpdateInput& input) const {
    try {
      UpdateSparseModel(input, {}, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

// Largest distance of a camera centre from the truth, metres.
double WorstPosition(const Reconstruction& model, const WorldFrame& frame) {
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    for (const auto& [id, image] : model.images) {
      if (image.name != ArcName(i)) continue;
      const GeoPosition truth = GeoFromEnu(testing_support::kTestOrigin, CameraCenter(ArcPose(i)));
      const Eigen::Vector3d in_frame = EnuFromGeo(frame.origin.value(), truth);
      worst = std::max(worst, (CameraCenter(image.cam_from_world) - in_frame).norm());
    }
  }
  return worst;
}

Camera TrueCamera() { return ToCamera(testing_support::kTestCamera); }

std::string ModelBytes(const Reconstruction& model, const fs::path& folder) {
  WriteReconstructionBinary(model, folder);
  return ReadFile(folder / "cameras.bin") + ReadFile(folder / "images.bin") +
         ReadFile(folder / "points3D.bin");
}

TEST_F(SparseUpdate, RegistersAllPhotosInMetresAndGivesTheSameBytesOnEveryRun) {
  WriteArcPhotos(images(), 0, 12);
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  const SparseUpdateResult result = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(result.registered.size(), 12u);
  EXPECT_TRUE(result.unregistered.empty());
  EXPECT_TRUE(result.frame.is_metric_enu);
  ASSERT_TRUE(result.georegistration);
  EXPECT_TRUE(result.georegistration->outliers.empty());
  EXPECT_LT(WorstPosition(result.model, result.frame), 0.05);
  EXPECT_LT(result.mean_error_px, 0.6);
  ASSERT_TRUE(result.positions);
  EXPECT_EQ(result.positions->residuals.size(), 12u);
  WriteGeoregistration(result, folder_);
  const Json report = ReadJsonFile(folder_ / "georegistration.json");
  EXPECT_EQ(report["scale"].get<double>(), result.georegistration->world_from_model->scale);
  EXPECT_LT(report["rms_m"].get<double>(), 0.05);
  EXPECT_EQ(report["photos"].size(), 12u);
  EXPECT_GT(result.model.points.size(), 200u);
  for (const char* step : {"features", "matching", "verification", "mapping"}) {
    EXPECT_TRUE(result.cost_of_step.count(step)) << step;
  }

  SparseUpdateInput again = Input("again");
  again.camera = TrueCamera();
  const SparseUpdateResult second = UpdateSparseModel(again, {}, {});
  EXPECT_TRUE(ModelBytes(result.model, folder_ / "a") == ModelBytes(second.model, folder_ / "b"));
}

TEST_F(SparseUpdate, AddsPhotosWithoutMovingTheOldOnesAndRestsWhenThereIsNothingNew) {
  WriteArcPhotos(images(), 0, 10);
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  SparseUpdateOptions options;
  options.adjust_after_growth = 10;  // never
  const SparseUpdateResult first = UpdateSparseModel(input, options, {});
  ASSERT_EQ(first.registered.size(), 10u);

  WriteArcPhotos(images(), 10, 13);
  input.model = &first.model;
  input.frame = first.frame;
  input.state = first.state;
  const SparseUpdateResult second = UpdateSparseModel(input, options, {});
  EXPECT_EQ(second.registered.size(), 13u);
  EXPECT_EQ(second.newly_registered,
            (std::vector<std::string>{ArcName(10), ArcName(11), ArcName(12)}));
  EXPECT_FALSE(second.georegistration);
  for (const auto& [id, image] : first.model.images) {
    const Rigid3d& now = second.model.images.at(id).cam_from_world;
    EXPECT_LT((CameraCenter(now) - CameraCenter(image.cam_from_world)).norm(), 1e-9);
    EXPECT_LT(now.rotation.angularDistance(image.cam_from_world.rotation), 1e-9);
  }
  EXPECT_LT(WorstPosition(second.model, second.frame), 0.1);

  input.model = &second.model;
  input.state = second.state;
  const fs::file_time_type written = fs::last_write_time(input.database_path);
  const SparseUpdateResult third = UpdateSparseModel(input, options, {});
  EXPECT_FALSE(third.changed);
  EXPECT_EQ(fs::last_write_time(input.database_path), written);
}

TEST_F(SparseUpdate, AdjustsAllPosesAfterGrowthAndKeepsTheFrame) {
  WriteArcPhotos(images(), 0, 8);
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  const SparseUpdateResult first = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(first.state.photos_at_last_adjustment, 8);
  EXPECT_TRUE(first.adjustment_of_all);
  WriteArcPhotos(images(), 8, 12);
  input.model = &first.model;
  input.frame = first.frame;
  input.state = first.state;
  const SparseUpdateResult second = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(second.state.photos_at_last_adjustment, 12);
  EXPECT_EQ(second.registered.size(), 12u);
  EXPECT_LT(WorstPosition(second.model, second.frame), 0.2);
}

TEST_F(SparseUpdate, ContinuesSomebodysProjectWithoutTouchingIt) {
  WriteArcPhotos(images(), 0, 8);
  SparseUpdateInput theirs = Input("theirs");
  theirs.camera = TrueCamera();
  const SparseUpdateResult first = UpdateSparseModel(theirs, {}, {});
  const std::string database_bytes = ReadFile(theirs.database_path);

  WriteArcPhotos(images(), 8, 10);
  SparseUpdateInput ours = Input("ours");
  ours.base_database_path = theirs.database_path;
  ours.model = &first.model;
  const SparseUpdateResult second = UpdateSparseModel(ours, {}, {});
  EXPECT_EQ(second.registered.size(), 10u);
  EXPECT_TRUE(second.frame.is_metric_enu);  // georegistered now: its frame was not known
  EXPECT_TRUE(ReadFile(theirs.database_path) == database_bytes);
  const Database database = Database::Open(ours.database_path, Database::Access::kReadOnly);
  EXPECT_EQ(database.ReadImages().size(), 10u);
  EXPECT_EQ(database.ReadCameras().size(), 1u);  // the photos share their camera
  EXPECT_EQ(database.ReadImages().at(9).name, ArcName(8));

  ours = Input("mixed");  // a model and a database that do not belong together
  ours.base_database_path = theirs.database_path;
  Reconstruction renamed = first.model;
  renamed.images.begin()->second.name = "else.jpg";
  ours.model = &renamed;
  EXPECT_NE(MessageOf(ours).find("else.jpg"), std::string::npos);
}

TEST_F(SparseUpdate, NamesPhotosThatDoNotRegisterAndOutliersOfTheirPositions) {
  WriteArcPhotos(images(), 0, 10);
  cv::Mat noise(240, 320, CV_8UC3);
  cv::randu(noise, 0, 255);
  cv::imwrite((images() / "stranger.jpg").string(), noise);
  SparseUpdateInput input = Input();
  input.geo_position_of_photo[ArcName(3)] =
      GeoFromEnu(testing_support::kTestOrigin, Eigen::Vector3d(300, 0, 0));
  const SparseUpdateResult result = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(result.unregistered, (std::vector<std::string>{"stranger.jpg"}));
  ASSERT_TRUE(result.georegistration);
  ASSERT_EQ(result.georegistration->outliers.size(), 1u);
  EXPECT_EQ(result.georegistration->outliers[0].name, ArcName(3));
  EXPECT_LT(WorstPosition(result.model, result.frame), 0.3);  // focal length estimated
  // A stranger alone is no reason to work again.
  input.model = &result.model;
  input.frame = result.frame;
  input.state = result.state;
  EXPECT_FALSE(UpdateSparseModel(input, {}, {}).changed);
}

TEST_F(SparseUpdate, WorksWithoutPositionsAndSaysThatItIsNotMetric) {
  WriteArcPhotos(images(), 0, 6, {.gps = false, .focal = true});
  const SparseUpdateResult result = UpdateSparseModel(Input(), {}, {});
  EXPECT_EQ(result.registered.size(), 6u);
  EXPECT_FALSE(result.frame.is_metric_enu);
  EXPECT_FALSE(result.georegistration);
}

TEST_F(SparseUpdate, TakesLocalPositions) {
  WriteArcPhotos(images(), 0, 8, {.gps = false, .focal = true});
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  for (int i = 0; i < 8; ++i) {
    input.local_position_of_photo[ArcName(i)] = CameraCenter(ArcPose(i));
  }
  const SparseUpdateResult result = UpdateSparseModel(input, {}, {});
  EXPECT_TRUE(result.frame.is_metric_enu);
  EXPECT_FALSE(result.frame.origin);
  for (const auto& [id, image] : result.model.images) {
    const Eigen::Vector3d truth = input.local_position_of_photo.at(image.name);
    EXPECT_LT((CameraCenter(image.cam_from_world) - truth).norm(), 0.05);
  }
}

TEST_F(SparseUpdate, RefusesBadInputInOneClearLine) {
  EXPECT_NE(MessageOf(Input()).find("no photos"), std::string::npos);
  WriteArcPhotos(images(), 0, 1);
  EXPECT_NE(MessageOf(Input()).find(ArcName(0)), std::string::npos);
  WriteArcPhotos(images(), 1, 4);
  SparseUpdateInput input = Input();
  input.image_path = folder_ / "nowhere";
  EXPECT_NE(MessageOf(input).find("nowhere"), std::string::npos);
  input = Input();
  input.colmap_path = folder_ / "no_colmap";
  EXPECT_NE(MessageOf(input).find("apt-get install colmap"), std::string::npos);
  input = Input();
  input.geo_position_of_photo["other.jpg"] = testing_support::kTestOrigin;
  EXPECT_NE(MessageOf(input).find("other.jpg"), std::string::npos);
  input = Input();
  input.camera = Camera{CameraModel::kSimplePinhole, 640, 480, {500, 320, 240}};
  EXPECT_NE(MessageOf(input).find("640"), std::string::npos);
  EXPECT_FALSE(fs::exists(Input().database_path));
  const std::string bytes = ReadFile(images() / ArcName(2));
  std::ofstream(images() / ArcName(2), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_NE(MessageOf(Input()).find(ArcName(2)), std::string::npos);
}

TEST_F(SparseUpdate, RefusesPhotosThatDoNotOverlapAndKeepsTheOldDatabase) {
  for (int i = 0; i < 4; ++i) {
    cv::Mat noise(240, 320, CV_8UC3);
    cv::theRNG().state = static_cast<std::uint64_t>(i + 1);
    cv::randu(noise, 0, 255);
    cv::imwrite((images() / ("noise" + std::to_string(i) + ".jpg")).string(), noise);
  }
  const std::string message = MessageOf(Input());
  EXPECT_NE(message.find("do not overlap"), std::string::npos) << message;
  EXPECT_NE(message.find("noise0.jpg"), std::string::npos);
  std::ofstream(Input("broken").database_path) << "this is no database";
  EXPECT_NE(MessageOf(Input("broken")).find("broken.db"), std::string::npos);
  EXPECT_EQ(ReadFile(Input("broken").database_path), "this is no database");
}

TEST_F(SparseUpdate, BuildsOnTheFeaturesAndMatchesOfPlainColmap) {
  WriteArcPhotos(images(), 0, 8);
  const fs::path theirs = folder_ / "theirs.db";
  ColmapProgram colmap("");
  const fs::path log = folder_ / "colmap.log";
  colmap.Run("feature_extractor",
             {{"database_path", theirs.string()},
              {"image_path", images().string()},
              {"ImageReader.single_camera", "1"},
              {"SiftExtraction.first_octave", "0"},
              {"SiftExtraction.use_gpu", "0"}},
             log, {});
  colmap.Run("exhaustive_matcher",
             {{"database_path", theirs.string()}, {"SiftMatching.use_gpu", "0"}}, log, {});
  const std::string bytes = ReadFile(theirs);

  SparseUpdateInput input = Input("ours");
  input.base_database_path = theirs;
  const SparseUpdateResult first = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(first.registered.size(), 8u);
  EXPECT_EQ(first.num_pairs, 0);  // all were matched
  WriteArcPhotos(images(), 8, 10);
  input.base_database_path.clear();
  input.model = &first.model;
  input.frame = first.frame;
  input.state = first.state;
  EXPECT_EQ(UpdateSparseModel(input, {}, {}).registered.size(), 10u);
  EXPECT_TRUE(ReadFile(theirs) == bytes);
  const Database kept = Database::Open(theirs, Database::Access::kReadOnly);
  const Database ours = Database::Open(input.database_path, Database::Access::kReadOnly);
  for (const auto& [id, count] : kept.NumKeypoints()) {
    EXPECT_TRUE(kept.ReadKeypoints(id) == ours.ReadKeypoints(id));
  }
  for (const auto& [pair, count] : kept.NumMatches()) {
    EXPECT_EQ(kept.ReadMatches(pair), ours.ReadMatches(pair));
  }
}

// Photos at both ends of a wide arc, then those between.
TEST_F(SparseUpdate, NamesAnotherModelAndJoinsItWhenPhotosBridgeTheGap) {
  WriteArcPhotos(images(), 0, 8);
  WriteArcPhotos(images(), 18, 23);
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  const SparseUpdateResult first = UpdateSparseModel(input, {}, {});
  ASSERT_EQ(first.registered.size(), 8u);
  ASSERT_EQ(first.other_models.size(), 1u);
  EXPECT_EQ(first.other_models[0], first.unregistered);
  EXPECT_EQ(first.unregistered.front(), ArcName(18));

  WriteArcPhotos(images(), 8, 18);
  input.model = &first.model;
  input.frame = first.frame;
  input.state = first.state;
  const SparseUpdateResult second = UpdateSparseModel(input, {}, {});
  EXPECT_EQ(second.registered.size(), 23u);
  EXPECT_TRUE(second.unregistered.empty());
  EXPECT_TRUE(second.other_models.empty());
  EXPECT_LT(WorstPosition(second.model, second.frame), 0.2);
}

TEST_F(SparseUpdate, RefusesASecondUpdateOfTheSameDatabase) {
  WriteArcPhotos(images(), 0, 4);
  const UpdateLock held(Input().database_path);
  EXPECT_NE(MessageOf(Input()).find("another update"), std::string::npos);
}

TEST_F(SparseUpdate, WritesWhatColmapsOwnCommandsAccept) {
  WriteArcPhotos(images(), 0, 8);
  SparseUpdateInput input = Input();
  input.camera = TrueCamera();
  const SparseUpdateResult first = UpdateSparseModel(input, {}, {});
  WriteReconstructionBinary(first.model, folder_ / "first");
  WriteArcPhotos(images(), 8, 11);
  input.model = &first.model;
  input.frame = first.frame;
  input.state = first.state;
  const SparseUpdateResult second = UpdateSparseModel(input, {}, {});
  ASSERT_EQ(second.registered.size(), 11u);
  WriteReconstructionBinary(second.model, folder_ / "second");
  fs::create_directories(folder_ / "out");
  const fs::path log = folder_ / "colmap.log";
  const std::string model = (folder_ / "second").string(), out = (folder_ / "out").string();
  ColmapProgram colmap("");
  colmap.Run("model_analyzer", {{"path", model}}, log, {});
  EXPECT_NE(ReadFile(log).find("Registered images: 11"), std::string::npos) << ReadFile(log);
  const auto run = [&](const std::vector<std::string>& arguments) {
    ChildProcessOptions options;
    options.arguments = {colmap.path().string()};
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    options.environment["QT_QPA_PLATFORM"] = "offscreen";
    const ChildProcessResult result = RunChildProcess(options, {});
    EXPECT_EQ(result.exit_code, 0) << arguments[0] << ": " << result.output;
    return result.output;
  };
  run({"model_comparer", "--input_path1", (folder_ / "first").string(), "--input_path2", model,
       "--output_path", out});
  run({"bundle_adjuster", "--input_path", model, "--output_path", out,
       "--BundleAdjustment.max_num_iterations", "3"});
  EXPECT_EQ(ReadReconstruction(out).images.size(), 11u);
  const fs::path empty = folder_ / "empty.db", merged = folder_ / "merged.db";
  run({"database_creator", "--database_path", empty.string()});
  run({"database_merger", "--database_path1", input.database_path.string(), "--database_path2",
       empty.string(), "--merged_database_path", merged.string()});
  EXPECT_EQ(Database::Open(merged, Database::Access::kReadOnly).ReadImages().size(), 11u);
}

TEST(SparseState, ComesBackAndDefaultsWhenThereIsNone) {
  const fs::path path = fs::path(testing::TempDir()) / "sparse_state.json";
  fs::remove(path);
  EXPECT_EQ(ReadSparseState(path).photos_at_last_adjustment, 0);
  WriteSparseState({7, {"a.jpg", "b c.jpg"}}, path);
  EXPECT_EQ(ReadSparseState(path).photos_at_last_adjustment, 7);
  EXPECT_EQ(ReadSparseState(path).unregistered, (std::vector<std::string>{"a.jpg", "b c.jpg"}));
  std::ofstream(path) << "{";
  EXPECT_THROW(ReadSparseState(path), Error);
  fs::remove(path);
}

TEST(SparseUpdateOptions, NamesWhatIsWrong) {
  SparseUpdateOptions options;
  EXPECT_EQ(options.Check(), "");
  options.first_octave = 9;
  EXPECT_THROW(UpdateSparseModel({}, options, {}), UsageError);
  options = {};
  options.pairing.min_neighbors = 0;
  EXPECT_NE(options.Check().find("Pairing.min_neighbors"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
