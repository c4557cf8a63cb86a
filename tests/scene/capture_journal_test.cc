#include "colmap_ext/scene/capture_journal.h"

#include <gtest/gtest.h>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/files.h"
#include "scene/damaged_text.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

CaptureRecord SomeRecord() {
  CaptureRecord record;
  record.index = 7;
  record.time = "2026-03-01T10:20:30.5Z";
  record.position = {47.1, 8.5, 512.25};
  record.sigma_horizontal_m = 0.8;
  record.sigma_vertical_m = 1.4;
  record.cam_from_enu = CamFromWorld({0, 0, 0}, {1.2, -0.6}).rotation;
  return record;
}

TEST(CaptureJournal, ComesBack) {
  const TestFolder folder;
  CaptureRecord bare;
  bare.position = {-33, 151, 20};
  WriteFileAtomically(folder / "captures.jsonl", CaptureJournalLine("a/b c.jpg", SomeRecord()) +
                                                     CaptureJournalLine("d.jpg", bare));
  const auto records = ReadCaptureJournal(folder / "captures.jsonl");
  ASSERT_EQ(records.size(), 2U);
  const CaptureRecord& record = records.at("a/b c.jpg");
  EXPECT_EQ(record.index, 7);
  EXPECT_EQ(record.time, SomeRecord().time);
  EXPECT_EQ(record.position.height_m, 512.25);
  EXPECT_EQ(record.sigma_vertical_m, 1.4);
  EXPECT_LT(record.cam_from_enu->angularDistance(*SomeRecord().cam_from_enu), 1e-12);
  EXPECT_FALSE(records.at("d.jpg").cam_from_enu);
  EXPECT_FALSE(records.at("d.jpg").sigma_horizontal_m);
}

TEST(CaptureJournal, AttitudeIsThatOfMavlink) {
  const TestFolder folder;
  // Identity: the camera looks north, level, its right to the east.
  WriteFileAtomically(folder / "captures.jsonl",
                      "{\"type\":\"capture\",\"file\":\"a.jpg\",\"lat\":1,\"lon\":2,"
                      "\"height_m\":3,\"q\":[1,0,0,0]}\n");
  const auto records = ReadCaptureJournal(folder / "captures.jsonl");
  const Rigid3d north = CamFromWorld({0, 0, 0}, {0, 0});
  EXPECT_LT(records.at("a.jpg").cam_from_enu->angularDistance(north.rotation), 1e-12);
}

TEST(CaptureJournal, SkipsOtherEventsRepeatsFailuresAndACutLine) {
  const TestFolder folder;
  const std::string line = CaptureJournalLine("a.jpg", SomeRecord());
  WriteFileAtomically(folder / "captures.jsonl", "{\"type\":\"takeoff\"}\n\n" + line + line +
                                                     "{\"type\":\"capture\",\"result\":0}\n" +
                                                     line.substr(0, 40));
  EXPECT_EQ(ReadCaptureJournal(folder / "captures.jsonl").size(), 1U);
}

TEST(CaptureJournal, BadLinesAreNamed) {
  const TestFolder folder;
  const auto expect = [&](const std::string& text, const std::string& message) {
    WriteFileAtomically(folder / "captures.jsonl", text + "\n");
    ExpectError([&] { ReadCaptureJournal(folder / "captures.jsonl"); },
                {"captures.jsonl", message});
  };
  const std::string start = "{\"type\":\"capture\",\"file\":\"a.jpg\",";
  expect("[]", "line 1: not a JSON object");
  expect("\n{", "line 2: not a JSON object");
  expect(start + "\"lon\":2,\"height_m\":3}", "line 1: top level: \"lat\" is missing");
  expect(start + "\"lat\":91,\"lon\":2,\"height_m\":3}", "out of range");
  expect(start + "\"lat\":1,\"lon\":2,\"height_m\":3,\"q\":[2,0,0,0]}", "/q: the quaternion");
  expect(start + "\"lat\":1,\"lon\":2,\"height_m\":3,\"sigma_h_m\":0}",
         "/sigma_h_m: must be above");
  CaptureRecord other = SomeRecord();
  other.index = 8;
  expect(CaptureJournalLine("a.jpg", SomeRecord()) + CaptureJournalLine("a.jpg", other),
         "line 2: /file: this picture was recorded before");
}

TEST(CaptureJournal, DamagedFilesAreReadOrRefused) {
  const TestFolder folder;
  const std::string text = CaptureJournalLine("a.jpg", SomeRecord()) +
                           CaptureJournalLine("b.jpg", SomeRecord()) + "{\"type\":\"land\"}\n";
  const int refused = CountRefused(text, folder / "captures.jsonl", 400,
                                   [](const auto& path) { ReadCaptureJournal(path); });
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace colmap_ext
