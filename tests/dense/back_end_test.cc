#include "colmap_ext/dense/back_end.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/dense/texture.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/files.h"
#include "dense/wall_survey.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Points on the panel, in view of every photo.
OrientedPoints PanelPoints() {
  OrientedPoints points;
  for (int i = 0; i < 200; ++i) {
    OrientedPoint point;
    point.position = {-1 + 0.01 * i, 6.5, 0};
    point.normal = {0, -1, 0};
    points.push_back(point);
  }
  return points;
}

// A `colmap` with CUDA that writes the true depth, and the panel as its cloud.
struct FakeColmap {
  bool writes_depth = true, writes_cloud = true;
  OrientedPoints cloud = PanelPoints();
  std::vector<std::string> commands;
  std::string help = "COLMAP 3.8 (Commit Unknown on Unknown with CUDA)";
};

class BackEnds : public ::testing::Test {
 protected:
  BackEnds() : survey_(test::WallSurvey(3)) {
    model_ = test::WriteSurvey(test::WallScene(), survey_, folder_ / "images");
    photos_ = std::make_unique<PhotoSource>(model_, folder_ / "images", 0);
    request_.photos = photos_.get();
    request_.workspace_path = folder_ / "out";
  }

  std::unique_ptr<DenseBackEnd> Colmap(FakeColmap* fake) {
    ColmapTool tool;
    tool.help = fake->help;
    tool.run = [this, fake](const std::string& command, const ColmapTool::Arguments& arguments,
                            const fs::path&, const JobControl&) {
      fake->commands.push_back(command);
      if (command == "patch_match_stereo" && fake->writes_depth) WriteTrueDepth();
      if (command == "stereo_fusion" && fake->writes_cloud) {
        for (const auto& [name, value] : arguments) {
          if (name == "output_path") WriteOrientedPoints(fake->cloud, value);
        }
      }
    };
    return MakeColmapBackEnd(tool);
  }

  void WriteTrueDepth() const {
    for (const PosedPhoto& photo : survey_.photos.photos) {
      cv::Mat depth;
      survey_.depth[photo.image_id - 1].convertTo(depth, CV_32F);
      WriteDenseMap(MapOf(depth), DenseWorkspace{request_.workspace_path}.depth_map(photo.name));
    }
  }

  TestFolder folder_;
  test::AnalyticSurvey survey_;
  Reconstruction model_;
  std::unique_ptr<PhotoSource> photos_;
  DenseRequest request_;
};

TEST_F(BackEnds, AutoTakesTheFirstThatCanBeUsed) {
  FakeColmap with_cuda, without_cuda;
  without_cuda.help = "COLMAP 3.8 (Commit Unknown on Unknown without CUDA)";
  std::vector<std::unique_ptr<DenseBackEnd>> all;
  all.push_back(Colmap(&without_cuda));
  all.push_back(MakeBuiltinBackEnd({}));
  EXPECT_EQ(ChooseBackEnd("auto", all).Name(), "builtin");
  EXPECT_EQ(ChooseBackEnd("builtin", all).Name(), "builtin");
  ExpectError([&] { ChooseBackEnd("colmap", all); }, {"without CUDA", "builtin"});
  ExpectError([&] { ChooseBackEnd("magic", all); }, {"magic", "auto, colmap, builtin"});
  all.insert(all.begin(), Colmap(&with_cuda));
  EXPECT_EQ(ChooseBackEnd("auto", all).Name(), "colmap");
  all.clear();
  all.push_back(MakeColmapBackEnd({}));
  ExpectError([&] { ChooseBackEnd("auto", all); }, {"no dense back end", "install"});
}

TEST_F(BackEnds, ColmapRunsItsStepsOnOurWorkspace) {
  FakeColmap fake;
  const OrientedPoints points = Colmap(&fake)->Reconstruct(request_, JobControl());
  EXPECT_EQ(points.size(), 200U);
  EXPECT_EQ(fake.commands, (std::vector<std::string>{"patch_match_stereo", "stereo_fusion"}));
  EXPECT_TRUE(fs::exists(folder_ / "out" / "images" / "photo_100.png"));
  EXPECT_NE(ReadFile(folder_ / "out" / "stereo" / "patch-match.cfg").find("__auto__"),
            std::string::npos);
}

TEST_F(BackEnds, EmptyOrAbsurdResultsOfColmapAreErrors) {
  FakeColmap no_depth, no_cloud, empty, far_away;
  no_depth.writes_depth = false;
  ExpectError([&] { Colmap(&no_depth)->Reconstruct(request_, JobControl()); },
              {"patch_match_stereo", "0 of 3"});
  no_cloud.writes_cloud = false;
  ExpectError([&] { Colmap(&no_cloud)->Reconstruct(request_, JobControl()); }, {"stereo_fusion"});
  empty.cloud.clear();
  ExpectError([&] { Colmap(&empty)->Reconstruct(request_, JobControl()); }, {"only 0 points"});
  for (OrientedPoint& point : far_away.cloud) point.position.y() = -100;
  ExpectError([&] { Colmap(&far_away)->Reconstruct(request_, JobControl()); }, {"outside"});
}

class OpenMvs : public BackEnds {
 protected:
  OpenMvs() : path_before_(getenv("PATH")) {
    WriteOrientedPoints(PanelPoints(), folder_ / "panel.ply");
    setenv("PATH", ((folder_ / "bin").string() + ":" + path_before_).c_str(), 1);
    Program("InterfaceCOLMAP", "echo scene > " + (folder_ / "out/openmvs/scene.mvs").string());
    Program("DensifyPointCloud", "cp " + (folder_ / "panel.ply").string() + " " +
                                     (folder_ / "out/openmvs/scene_dense.ply").string());
  }
  ~OpenMvs() override { setenv("PATH", path_before_.c_str(), 1); }

  void Program(const std::string& name, const std::string& script) {
    const fs::path path = folder_ / "bin" / name;
    WriteFileAtomically(path, "#!/bin/sh\n" + script + "\n");
    fs::permissions(path, fs::perms::owner_all);
  }

  std::string path_before_;
};

TEST_F(OpenMvs, IsUsedWhenItsProgramsAreThere) {
  const auto back_end = MakeOpenMvsBackEnd();
  EXPECT_EQ(back_end->WhyUnavailable(), "");
  EXPECT_EQ(back_end->Reconstruct(request_, JobControl()).size(), 200U);
  fs::remove(folder_ / "bin" / "DensifyPointCloud");
  EXPECT_NE(back_end->WhyUnavailable().find("DensifyPointCloud"), std::string::npos);
}

TEST_F(OpenMvs, FailuresAndEmptyOutputsAreErrors) {
  const auto back_end = MakeOpenMvsBackEnd();
  Program("DensifyPointCloud", "exit 0");
  ExpectError([&] { back_end->Reconstruct(request_, JobControl()); },
              {"DensifyPointCloud", "without an error", "log"});
  Program("InterfaceCOLMAP", "exit 3");
  ExpectError([&] { back_end->Reconstruct(request_, JobControl()); },
              {"InterfaceCOLMAP", "exit code 3"});
}

TEST_F(OpenMvs, TexturesASurface) {
  EXPECT_NE(WhyNoTexture().find("TextureMesh"), std::string::npos);
  // Takes the scene by -i, the mesh by -m and writes what -o names.
  Program("TextureMesh", "cat \"$4\" \"$6\" > \"$8\"");
  EXPECT_EQ(WhyNoTexture(), "");
  const fs::path mesh = folder_ / "surface.ply", textured = folder_ / "textured.obj";
  WriteFileAtomically(mesh, "mesh\n");
  TextureSurface({request_.workspace_path}, mesh, textured, JobControl());
  EXPECT_EQ(ReadFile(textured), "scene\nmesh\n");
  Program("TextureMesh", "exit 0");
  ExpectError([&] { TextureSurface({request_.workspace_path}, mesh, textured, JobControl()); },
              {"TextureMesh", "without an error", "textured.obj", "log"});
}

}  // namespace
}  // namespace colmap_ext
