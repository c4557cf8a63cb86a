#include "session/flight_recovery.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "colmap_ext/flight/flight_journal.h"
#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// A workspace whose session was killed: view 0 was stored, view 1 is on disk without a record of
// it, view 2 was taken and not fetched, view 3 was asked for, view 4 given up.
class FlightRecovery : public testing::Test {
 protected:
  FlightRecovery()
      : workspace_(fs::path(testing::TempDir()) / ("recovery_" + std::to_string(getpid()))) {
    fs::create_directories(workspace_.images());
    FlightJournal journal(JournalPath());
    std::vector<Json> records = {{{"type", "start"}}};
    for (int view = 0; view < 3; ++view) {
      CaptureReport report;
      report.record.index = 10 + view;
      report.record.position = {47.4, 8.5, 500};
      records.push_back(Ask(view));
      records.push_back(CaptureToJson(view, report));
      captures_ += CaptureJournalLine(Photo(view), report.record);
    }
    records.push_back({{"type", "stored"},
                       {"view", 0},
                       {"resolution", "low"},
                       {"file", Photo(0)},
                       {"sha256", "aa"}});
    records.push_back(Ask(3));
    records.push_back({{"type", "failed"}, {"view", 4}, {"reason", "the gimbal is stuck"}});
    journal.Append(records);
    for (const int view : {0, 1}) WriteFileAtomically(workspace_.images() / Photo(view), "photo");
    WriteFileAtomically(workspace_.images() / "captures.jsonl", captures_);
    WriteTruePoses({{"img_00010.jpg", PoseAt(10)},
                    {"img_00011.jpg", PoseAt(11)},
                    {"img_00012.jpg", PoseAt(12)}},
                   DronePath(workspace_) / "true_poses.txt");
  }
  ~FlightRecovery() override { fs::remove_all(workspace_.root()); }

  static std::string Photo(int view) { return "view_0000" + std::to_string(view) + ".jpg"; }
  static Json Ask(int view) {
    return {{"type", "ask"},
            {"view", view},
            {"photo", Photo(view)},
            {"sequence", view + 1},
            {"after_index", 9 + view}};
  }
  static Rigid3d PoseAt(double x) {
    return {Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0)};
  }
  fs::path JournalPath() const { return workspace_.root() / "flight" / "journal.jsonl"; }
  FlightLedger Ledger() const { return ReplayJournal(ReadFile(JournalPath()), "journal"); }
  std::map<std::string, Rigid3d> TruePoses() const {
    return PoseOfPhoto(ReadTruePoses(workspace_.root() / "truth" / "poses.txt"));
  }

  Workspace workspace_;
  std::string captures_;
};

TEST_F(FlightRecovery, WhatIsOnDiskIsStoredAndTheRestIsPendingAgain) {
  RecoverFromLastDrone(workspace_, false, JobControl());
  const FlightLedger ledger = Ledger();
  EXPECT_EQ(ledger.views.at(0).status, ViewStatus::kStored);
  EXPECT_EQ(ledger.views.at(1).status, ViewStatus::kStored);
  EXPECT_EQ(ledger.views.at(2).status, ViewStatus::kPending) << "the drone took it with it";
  EXPECT_EQ(ledger.views.at(3).status, ViewStatus::kPending);
  EXPECT_EQ(ledger.views.at(4).status, ViewStatus::kFailed);
  EXPECT_EQ(ledger.last_index, -1) << "the next drone counts from 0";
  for (const auto& [view, entry] : ledger.views) EXPECT_EQ(entry.capture.record.index, -1);
}

TEST_F(FlightRecovery, PhotosOnDiskKeepTheirTruePoses) {
  RecoverFromLastDrone(workspace_, false, JobControl());
  const auto poses = TruePoses();
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses.at(Photo(0)).translation.x(), 10);
  EXPECT_EQ(poses.at(Photo(1)).translation.x(), 11);
  EXPECT_FALSE(fs::exists(DronePath(workspace_))) << "the next drone wants an empty folder";
}

TEST_F(FlightRecovery, AnotherDroneDoesNotMoveTheFirstOnesPhotos) {
  RecoverFromLastDrone(workspace_, false, JobControl());
  WriteTruePoses({{"img_00010.jpg", PoseAt(-1)}}, DronePath(workspace_) / "true_poses.txt");
  RecoverFromLastDrone(workspace_, false, JobControl());
  EXPECT_EQ(TruePoses().at(Photo(0)).translation.x(), 10);
}

TEST_F(FlightRecovery, ReportsOfPhotosThatAreTakenAgainGo) {
  RecoverFromLastDrone(workspace_, false, JobControl());
  const auto captures = ReadCaptureJournal(workspace_.images() / "captures.jsonl");
  EXPECT_TRUE(captures.contains(Photo(0)));
  EXPECT_TRUE(captures.contains(Photo(1)));
  EXPECT_FALSE(captures.contains(Photo(2)));
}

class Warnings : public ProgressSink {
 public:
  void Message(LogLevel level, std::string_view text) override {
    if (level == LogLevel::kWarning) all += std::string(text) + "\n";
  }
  void Progress(std::string_view, std::size_t, std::size_t) override {}
  std::string all;
};

TEST_F(FlightRecovery, FullResolutionComesFromTheDroneOrIsToldMissing) {
  WriteFileAtomically(DronePath(workspace_) / "full" / "img_00010.jpg", "full");
  Warnings warnings;
  RecoverFromLastDrone(workspace_, true, JobControl(&warnings, nullptr));
  EXPECT_EQ(ReadFile(workspace_.images_full() / Photo(0)), "full");
  EXPECT_FALSE(fs::exists(workspace_.images_full() / Photo(1)));
  EXPECT_NE(warnings.all.find(Photo(1)), std::string::npos);
  EXPECT_EQ(warnings.all.find(Photo(0)), std::string::npos);
}

TEST_F(FlightRecovery, ANewWorkspaceNeedsNothing) {
  const Workspace fresh(workspace_.root() / "fresh");
  EXPECT_NO_THROW(RecoverFromLastDrone(fresh, true, JobControl()));
  EXPECT_FALSE(fs::exists(fresh.root() / "flight"));
}

TEST_F(FlightRecovery, ADamagedJournalIsAnError) {
  WriteFileAtomically(JournalPath(), "no json\n");
  EXPECT_THROW(RecoverFromLastDrone(workspace_, false, JobControl()), Error);
  EXPECT_TRUE(fs::exists(DronePath(workspace_))) << "nothing is thrown away before";
}

}  // namespace
}  // namespace colmap_ext
