#include "colmap_ext/report/session_page.h"

#include <gtest/gtest.h>

#include <fstream>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "report/made_up_workspace.h"
#include "report/page_data.h"
#include "report/page_photos.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// The value of `colmapExt.put("key", value);` in a data file.
Json ReadDataFile(const fs::path& path, const std::string& key) {
  const std::string text = ReadFile(path);
  const std::string head = "colmapExt.put(\"" + key + "\", ";
  const std::size_t begin = text.find(head);
  EXPECT_NE(begin, std::string::npos) << path;
  return Json::parse(text.substr(begin + head.size(), text.rfind(");") - begin - head.size()));
}

class SessionPageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    MakeWorkspace(root_ / "w", 2);
    for (const char* name : {"page.js", "page.css"}) {
      WriteFileAtomically(root_ / "assets" / name, std::string("/* ") + name + " */");
    }
    WriteFileAtomically(root_ / "assets" / "page.html", "<title>{{TITLE}}</title>{{STATUS}}");
    options_.assets_path = root_ / "assets";
    options_.photo_width_px = 240;
  }
  void TearDown() override { fs::remove_all(root_); }

  void Write() const { WriteSessionPage(workspace_, report(), {}, options_, {}); }
  fs::path report() const { return root_ / "w" / "report"; }

  // A folder of its own: tests run side by side.
  const fs::path root_ = fs::path(::testing::TempDir()) /
                         (std::string("session <page> ") +
                          ::testing::UnitTest::GetInstance()->current_test_info()->name());
  const Workspace workspace_{root_ / "w"};
  PageOptions options_;
};

TEST_F(SessionPageTest, HasEverythingThatItLinksTo) {
  Write();
  const Json session = ReadDataFile(report() / "data" / "session.js", "session");
  ASSERT_EQ(session["iterations"].size(), 2U);
  for (const Json& iteration : session["iterations"]) {
    for (const char* part : {"scene", "fused", "overlays"}) {
      const std::string link = iteration["data"][part].get<std::string>();
      EXPECT_TRUE(fs::is_regular_file(report() / link.substr(0, link.find('?')))) << link;
    }
    EXPECT_TRUE(fs::exists(report() / iteration["pictures"][0]["link"].get<std::string>()));
  }
  EXPECT_EQ(session["photo_folder"], "photos_240");
  EXPECT_EQ(ReadPhoto((report() / "photos_240" / "photo_100.jpg.jpg").string()).cols, 240);
  EXPECT_TRUE(fs::exists(report() / "assets" / "page.js"));
  EXPECT_NE(ReadFile(report() / "pictures.html").find("<html"), std::string::npos);
  EXPECT_NE(ReadFile(report() / "index.html").find("<title>w</title>"), std::string::npos);
}

TEST_F(SessionPageTest, HoldsTheIterationsNumbers) {
  const Json json = IterationForPage(IterationFiles{workspace_.iteration(1)});
  EXPECT_EQ(json["photos"]["list"].size(), static_cast<std::size_t>(PhotosOfIteration(1)));
  EXPECT_EQ(json["points"]["position"]["count"], 900);
  EXPECT_EQ(json["surface"]["position"]["count"], MakeHouse().mesh.vertices.size());
  EXPECT_EQ(json["surface"]["face"]["count"], MakeHouse().mesh.faces.size());
  const Json coverage = ReadJsonFile(IterationFiles{workspace_.iteration(1)}.coverage_json());
  EXPECT_EQ(json["coverage"]["counts"][0], coverage["uncovered"]);
  EXPECT_EQ(json["coverage"]["counts"][1], coverage["covered"]);
  EXPECT_EQ(json["coverage"]["counts"][2], coverage["ignored"]);
  EXPECT_TRUE(json["coverage"].contains("predicted_error_um"));
  EXPECT_EQ(json["coverage"]["score_255"]["count"], json["coverage"]["class"]["count"]);
  EXPECT_EQ(json["views"].size(), 4U);
  EXPECT_EQ(json["path"]["waypoints"].size(), 5U);
}

TEST_F(SessionPageTest, LeavesOutWhatAnIterationDoesNotHave) {
  const IterationFiles files{workspace_.iteration(0)};
  for (const fs::path& path : {files.surface_ply(), files.coverage_ply(), files.path_json(),
                               files.fused_ply(), files.folder / "overlays.json"}) {
    fs::remove(path);
  }
  Write();
  const Json json = ReadDataFile(report() / "data" / "000.js", "iteration/000");
  for (const char* part : {"surface", "coverage", "path"}) EXPECT_FALSE(json.contains(part));
  const Json session = ReadDataFile(report() / "data" / "session.js", "session");
  EXPECT_TRUE(session["iterations"][0]["data"]["fused"].is_null());
  EXPECT_TRUE(session["iterations"][0]["data"]["overlays"].is_null());
}

TEST_F(SessionPageTest, TheFusedCloudIsThinnedEvenly) {
  const IterationFiles files{workspace_.iteration(0)};
  const Json all = FusedCloudForPage(files, 1000000);
  EXPECT_EQ(all["position"]["count"], 4000);
  const Json thin = FusedCloudForPage(files, 500);
  EXPECT_EQ(thin["position"]["count"], 500);
  EXPECT_EQ(thin["total"], 4000);
  EXPECT_TRUE(FusedCloudForPage(files, 0).is_null());
}

TEST_F(SessionPageTest, WritesAgainOnlyWhatChanged) {
  Write();
  const auto time_of = [&](const char* name) {
    return fs::last_write_time(report() / "data" / name);
  };
  const auto first = time_of("000.js"), second = time_of("001.js"), fused = time_of("000_fused.js");
  const IterationFiles files{workspace_.iteration(1)};
  const std::string views = ReadFile(files.views_json());
  WriteFileAtomically(files.views_json(), "[]\n");
  options_.max_points = 100;
  Write();
  EXPECT_EQ(time_of("000.js"), first);
  EXPECT_NE(time_of("001.js"), second);
  EXPECT_NE(time_of("000_fused.js"), fused);
  EXPECT_EQ(ReadDataFile(report() / "data" / "001.js", "iteration/001")["views"].size(), 0U);
}

class Listener : public ProgressSink {
 public:
  void Message(LogLevel level, std::string_view text) override {
    if (level == LogLevel::kWarning) warnings += std::string(text) + "\n";
  }
  void Progress(std::string_view, std::size_t, std::size_t) override {}
  std::string warnings;
};

TEST_F(SessionPageTest, MissingPhotosAreNamed) {
  fs::remove(workspace_.images() / "photo_103.jpg");
  WriteFileAtomically(workspace_.images() / "photo_104.jpg", "no photo");
  Listener listener;
  WriteSessionPage(workspace_, report(), {}, options_, JobControl(&listener, nullptr));
  EXPECT_NE(listener.warnings.find("lacks 2 photos"), std::string::npos) << listener.warnings;
  EXPECT_NE(listener.warnings.find("photo_103.jpg"), std::string::npos) << listener.warnings;
  EXPECT_TRUE(fs::exists(report() / "index.html"));
}

TEST_F(SessionPageTest, PhotosAreWhereTheSessionSays) {
  EXPECT_EQ(PhotoFolderOfWorkspace(workspace_), workspace_.images());
  WriteFileAtomically(workspace_.state_json(), "{\"source\": \"photos /a b/c\"}");
  EXPECT_EQ(PhotoFolderOfWorkspace(workspace_), "/a b/c");
  fs::remove(workspace_.state_json());
  EXPECT_EQ(PhotoFolderOfWorkspace(workspace_), workspace_.images());
}

TEST_F(SessionPageTest, ClearErrors) {
  options_.assets_path = root_ / "nothing";
  EXPECT_THROW(Write(), Error);
  options_ = {};
  options_.photo_width_px = 10;
  EXPECT_THROW(Write(), UsageError);
  options_ = {};
  options_.max_points = -1;
  EXPECT_NE(options_.Check(), "");
  EXPECT_THROW(WriteSessionPage(Workspace(root_ / "empty"), report(), {}, {}, {}), Error);
}

}  // namespace
}  // namespace colmap_ext
