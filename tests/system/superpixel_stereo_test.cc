// superpixel_stereo as a whole command, and COLMAP's commands on what it wrote.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/ply.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/files.h"
#include "mvs/analytic_scene.h"
#include "program.h"

namespace colmap_ext {
namespace {

using testing::LookAt;

class SuperpixelStereoCommand : public ProgramTest {
 protected:
  // A box on a floor, seven photos and their sparse model, as `images` and `sparse`.
  SuperpixelStereoCommand() {
    testing::AnalyticScene scene;
    scene.rectangles.push_back({{-15, -15, 0}, {30, 0, 0}, {0, 30, 0}, {120, 140, 130}, 1, 50});
    scene.rectangles.push_back({{-1.5, -1.5, 2.5}, {3, 0, 0}, {0, 3, 0}, {50, 60, 200}, 4, 50});
    scene.rectangles.push_back({{-1.5, -1.5, 0}, {3, 0, 0}, {0, 0, 2.5}, {190, 70, 60}, 7, 50});
    scene.rectangles.push_back({{1.5, -1.5, 0}, {0, 3, 0}, {0, 0, 2.5}, {60, 170, 80}, 10, 50});
    std::vector<Rigid3d> poses;
    for (int i = 0; i < 7; ++i) {
      const double angle = 0.5 + 0.14 * (i - 3);
      poses.push_back(LookAt({9 * std::sin(angle), -9 * std::cos(angle), 6}, {0, 0, 0.5}));
    }
    const testing::AnalyticSurvey survey =
        testing::Survey(scene, testing::TestCamera(), poses, 500);
    Reconstruction model;
    model.cameras[1] = ToCamera(testing::TestCamera());
    std::filesystem::create_directories(folder_ / "images");
    for (const PosedPhoto& photo : survey.photos.photos) {
      model.images[photo.image_id] = {photo.name, 1, photo.cam_from_world, {}};
      cv::imwrite((folder_ / "images" / photo.name).string(), photo.bgr);
    }
    for (const SupportPoint& support : survey.photos.points) {
      const Point3DId id = model.points.size() + 1;
      SparsePoint& point = model.points[id];
      point.position = support.position;
      point.error_px = support.error_px;
      for (const int index : support.photo_indices) {
        const PosedPhoto& photo = survey.photos.photos[static_cast<std::size_t>(index)];
        SparseImage& image = model.images.at(photo.image_id);
        point.track.push_back({photo.image_id, static_cast<std::uint32_t>(image.keypoints.size())});
        image.keypoints.push_back(
            {photo.camera.Project(photo.cam_from_world * support.position), id});
      }
    }
    WriteReconstructionBinary(model, folder_ / "sparse");
  }

  ChildProcessResult RunStereo(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"superpixel_stereo",           "--input_path",
                                          (folder_ / "sparse").string(), "--image_path",
                                          (folder_ / "images").string(), "--output_path",
                                          (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  ChildProcessResult RunColmap(const std::vector<std::string>& arguments) const {
    ChildProcessOptions options;
    options.arguments = arguments;
    options.environment = {{"QT_QPA_PLATFORM", "offscreen"}, {"OMP_WAIT_POLICY", "passive"}};
    return RunChildProcess(options, JobControl());
  }
};

TEST_F(SuperpixelStereoCommand, ColmapFusesAndMeshesWhatItWrote) {
  const ChildProcessResult stereo = RunStereo({"--pictures", "1"});
  ASSERT_EQ(stereo.exit_code, 0) << stereo.output;
  const std::filesystem::path out = folder_ / "out";
  const ColoredMesh mesh = ReadColoredMesh(out / "fused_mesh.ply");
  EXPECT_GT(mesh.mesh.faces.size(), 2000u);
  EXPECT_GT(ReadOrientedPoints(out / "fused.ply").size(), 5000u);
  for (const char* picture : {"fused_mesh.png", "fused_points.png", "photo_103.png.depth.png",
                              "photo_103.png.normal.png", "photo_103.png.confidence.png"}) {
    EXPECT_FALSE(cv::imread((out / "pictures" / picture).string()).empty()) << picture;
  }
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
