// superpixel_stereo as a whole command, and COLMAP's commands on what it wrote.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/util/files.h"
#include "small_site.h"

namespace colmap_ext {
namespace {

class SuperpixelStereoCommand : public SmallSite {
 protected:
  ChildProcessResult RunStereo(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"superpixel_stereo",           "--input_path",
                                          (folder_ / "sparse").string(), "--image_path",
                                          (folder_ / "images").string(), "--output_path",
                                          (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
};

TEST_F(SuperpixelStereoCommand, ColmapFusesAndMeshesWhatItWrote) {
  const ChildProcessResult stereo = RunStereo({"--pictures", "1"});
  ASSERT_EQ(stereo.exit_code, 0) << stereo.output;
  const std::filesystem::path out = folder_ / "out";
  const ColoredMesh mesh = ReadColoredMesh(out / "fused_mesh.ply");
  EXPECT_GT(mesh.mesh.faces.size(), 2000u);
  EXPECT_GT(ReadOrientedPoints(out / "fused.ply").size(), 5000u);
  for (const char* picture :
       {"fused_mesh.png", "fused_points.png", "photo_103.png.depth.png", "photo_103.png.normal.png",
        "photo_103.png.confidence.png", "photo_103.png.cue_position.png",
        "photo_103.png.cue_normal.png", "photo_103.png.cue_view.png"}) {
    EXPECT_FALSE(cv::imread((out / "pictures" / picture).string()).empty()) << picture;
  }
  EXPECT_EQ(ReadDenseMap(out / "dense/stereo/confidence_cues/photo_103.png.bin").channels, 4);
  if (FindProgram("colmap").empty()) GTEST_SKIP() << "no colmap";

  const std::string cloud = (out / "colmap_fused.ply").string();
  const ChildProcessResult fusion =
      RunColmap({"colmap", "stereo_fusion", "--workspace_path", (out / "dense").string(),
                 "--input_type", "geometric", "--output_path", cloud});
  ASSERT_EQ(fusion.exit_code, 0) << fusion.output;
  EXPECT_EQ(fusion.output.find("WARNING"), std::string::npos) << fusion.output;
  const PlyData data = ReadPly(cloud);
  ASSERT_NE(data.FindElement("vertex"), nullptr);
  EXPECT_GT(data.FindElement("vertex")->count, 5000u);

  const std::string surface = (out / "colmap_surface.ply").string();
  const ChildProcessResult poisson =
      RunColmap({"colmap", "poisson_mesher", "--input_path", cloud, "--output_path", surface,
                 "--PoissonMeshing.depth", "7", "--PoissonMeshing.trim", "4"});
  ASSERT_EQ(poisson.exit_code, 0) << poisson.output;
  EXPECT_GT(ReadMesh(surface).faces.size(), 500u);
}

TEST_F(SuperpixelStereoCommand, GivesTheSameBytesWithAnyNumberOfThreads) {
  ASSERT_EQ(RunStereo().exit_code, 0);
  const std::string first = (folder_ / "out" / "fused_mesh.ply").string();
  std::filesystem::rename(first, folder_ / "first.ply");
  const std::vector<std::string> one_core = {"taskset", "-c", "0", COLMAP_EXT_PROGRAM,
                                             "superpixel_stereo"};
  ChildProcessOptions options;
  options.arguments = one_core;
  for (const std::string& word :
       {std::string("--input_path"), (folder_ / "sparse").string(), std::string("--image_path"),
        (folder_ / "images").string(), std::string("--output_path"), (folder_ / "out").string()}) {
    options.arguments.push_back(word);
  }
  ASSERT_EQ(RunChildProcess(options, JobControl()).exit_code, 0);
  EXPECT_EQ(ReadFile(first), ReadFile(folder_ / "first.ply"));
}

}  // namespace
}  // namespace colmap_ext
