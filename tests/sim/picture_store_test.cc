#include "colmap_ext/sim/picture_store.h"

#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/util/files.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::ErrorOf;
using test::ScratchFolder;

class PictureStoreTest : public ::testing::Test {
 protected:
  PictureStoreTest()
      : scene_(test::GroundScene(test::FlatMaterial(128))), renderer_(scene_, RenderOptions()) {
    options_.width = 160;
    options_.height = 92;
    options_.focal_px = 120;
    options_.full_width = 320;
    options_.full_height = 184;
  }

  ShutterEvent Event(int index) const {
    ShutterEvent event;
    event.index = index;
    event.time_boot_ms = static_cast<std::uint32_t>(1000 * index);
    event.position = {1.0 * index, -6, 4};
    event.direction = {0.1 * index, -0.6};
    event.gps = GeoFromEnu(scene_.origin, event.position + Eigen::Vector3d(0.4, 0, 0));
    event.sigma_horizontal_m = 0.3;
    return event;
  }

  PictureStore::Done Recorder() {
    return [this](const std::string& name, PhotoResolution resolution) {
      const std::lock_guard lock(mutex_);
      done_.push_back((resolution == PhotoResolution::kLow ? "low/" : "full/") + name);
    };
  }
  // What is done, once it is `count`; waits at most 20 s.
  std::vector<std::string> WaitFor(std::size_t count) {
    for (int i = 0; i < 2000; ++i) {
      {
        const std::lock_guard lock(mutex_);
        if (done_.size() >= count) return done_;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return {};
  }

  TexturedScene scene_;
  Renderer renderer_;
  SimulatedCameraOptions options_;
  ScratchFolder folder_{"store"};
  std::mutex mutex_;
  std::vector<std::string> done_;
};

TEST_F(PictureStoreTest, RendersLowPicturesFirstAndRecordsTheTruth) {
  const SimulatedCamera camera(renderer_, scene_.origin, options_);
  PictureStore store(camera, folder_.path(), true, Recorder(), JobControl());
  for (int index = 0; index < 4; ++index) store.Add(Event(index));
  EXPECT_EQ(store.List().size(), 4U);
  const auto done = WaitFor(8);
  ASSERT_EQ(done.size(), 8U);
  EXPECT_EQ(done[0], "low/img_00000.jpg");
  EXPECT_EQ(done.back(), "full/img_00003.jpg");
  EXPECT_EQ(store.NumWaiting(), 0);
  EXPECT_EQ(store.StateOf("img_00002.jpg", PhotoResolution::kFull), PictureState::kReady);
  EXPECT_EQ(store.StateOf("img_00009.jpg", PhotoResolution::kLow), PictureState::kUnknown);

  const auto poses = PoseOfPhoto(ReadTruePoses(folder_ / "true_poses.txt"));
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_LT((CameraCenter(poses.at("img_00002.jpg")) - Event(2).position).norm(), 1e-6);
  const auto journal = ReadCaptureJournal(folder_ / "captures.jsonl");
  EXPECT_EQ(journal.at("img_00003.jpg").index, 3);
  // EXIF holds what the receiver said, not the truth.
  const auto metadata = ReadPhotoMetadata(folder_.path() / "low" / "img_00001.jpg");
  const auto believed = EnuFromGeo(scene_.origin, *metadata.gps);
  EXPECT_LT((believed - Event(1).position - Eigen::Vector3d(0.4, 0, 0)).norm(), 2e-3);
  EXPECT_EQ(metadata.width, 160);
  EXPECT_EQ(ReadPhotoMetadata(folder_.path() / "full" / "img_00001.jpg").width, 320);
}

TEST_F(PictureStoreTest, StopsWithoutRenderingWhatWaits) {
  const SimulatedCamera camera(renderer_, scene_.origin, options_);
  {
    PictureStore store(camera, folder_.path(), false, Recorder(), JobControl());
    for (int index = 0; index < 200; ++index) store.Add(Event(index));
    EXPECT_EQ(store.StateOf("img_00002.jpg", PhotoResolution::kFull), PictureState::kUnknown);
  }
  EXPECT_LT(done_.size(), 150U);
}

TEST_F(PictureStoreTest, AFailureIsReported) {
  const SimulatedCamera camera(renderer_, scene_.origin, options_);
  test::RecordingSink sink;
  PictureStore store(camera, folder_.path(), false, Recorder(), JobControl(&sink, nullptr));
  std::filesystem::create_directories(folder_.path() / "low" / "img_00000.jpg" / "in the way");
  store.Add(Event(0));
  ASSERT_EQ(WaitFor(1).size(), 1U);
  EXPECT_EQ(store.StateOf("img_00000.jpg", PhotoResolution::kLow), PictureState::kFailed);
}

TEST_F(PictureStoreTest, AnEarlierFlightIsNotOverwritten) {
  WriteFileAtomically(folder_.path() / "low" / "img_00000.jpg", "");
  const SimulatedCamera camera(renderer_, scene_.origin, options_);
  const auto open = [&] { PictureStore(camera, folder_.path(), true, Recorder(), JobControl()); };
  EXPECT_NE(ErrorOf(open).find("earlier flight"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
