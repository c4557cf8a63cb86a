// dense_reconstructor and model_evaluator as whole commands.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/files.h"
#include "small_site.h"

namespace colmap_ext {
namespace {

class DenseReconstructorCommand : public SmallSite {
 protected:
  std::vector<std::string> DenseArguments() const {
    return {"dense_reconstructor", "--backend",    "builtin",       "--input_path", Path("sparse"),
            "--image_path",        Path("images"), "--output_path", Path("dense")};
  }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  // When each file of a folder was written.
  static std::map<std::string, std::filesystem::file_time_type> WriteTimes(
      const std::filesystem::path& folder) {
    std::map<std::string, std::filesystem::file_time_type> times;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      times[entry.path().filename().string()] = entry.last_write_time();
    }
    return times;
  }

  // The box and the floor around it, as the photos show them.
  void WriteTruth() const {
    TriangleMesh truth;
    const auto add = [&truth](const Eigen::Vector3d& a, const Eigen::Vector3d& u,
                              const Eigen::Vector3d& v) {
      const int first = static_cast<int>(truth.vertices.size());
      truth.vertices.insert(truth.vertices.end(), {a, a + u, a + u + v, a + v});
      truth.faces.emplace_back(first, first + 1, first + 2);
      truth.faces.emplace_back(first, first + 2, first + 3);
    };
    add({-1.5, -1.5, 2.5}, {3, 0, 0}, {0, 3, 0});
    add({-1.5, -1.5, 0}, {3, 0, 0}, {0, 0, 2.5});
    add({1.5, -1.5, 0}, {0, 3, 0}, {0, 0, 2.5});
    WriteMesh(truth, folder_ / "truth.ply");
  }
};

TEST_F(DenseReconstructorCommand, PhotosToADenseModelNearTheTruth) {
  const ChildProcessResult dense = Run(DenseArguments());
  ASSERT_EQ(dense.exit_code, 0) << dense.output;
  EXPECT_GT(ReadOrientedPoints(folder_ / "dense" / "fused.ply").size(), 5000u);
  EXPECT_GT(ReadMesh(folder_ / "dense" / "surface.ply").faces.size(), 2000u);

  WriteTruth();
  const ChildProcessResult evaluation =
      Run({"model_evaluator", "--mesh_path", Path("dense/surface.ply"), "--ground_truth_path",
           Path("truth.ply"), "--input_path", Path("sparse"), "--output_path",
           Path("evaluation.json"), "--histogram_path", Path("histogram.png"),
           "--ModelEvaluator.icp_iterations", "0", "--ModelEvaluator.thresholds", "1in,10cm"});
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.output;
  const auto json = nlohmann::json::parse(ReadFile(folder_ / "evaluation.json"));
  EXPECT_LT(json.at("median_error_m").get<double>(), 0.03) << evaluation.output;
  EXPECT_GT(json.at("seen").at("completeness").at("100mm").get<double>(), 0.9);
  EXPECT_EQ(json.at("scale").get<double>(), 1.0);
  EXPECT_FALSE(cv::imread(Path("histogram.png")).empty());
}

TEST_F(DenseReconstructorCommand, AdjustedPosesAndASecondRunThatOnlyReads) {
  std::vector<std::string> arguments = DenseArguments();
  arguments.insert(arguments.end(), {"--adjust", "1", "--mesh", "0"});
  const ChildProcessResult first = Run(arguments);
  ASSERT_EQ(first.exit_code, 0) << first.output;
  const std::string points = ReadFile(folder_ / "dense" / "fused.ply");
  const auto times = WriteTimes(folder_ / "dense" / "builtin");
  EXPECT_FALSE(times.empty());
  const ChildProcessResult second = Run(arguments);
  ASSERT_EQ(second.exit_code, 0) << second.output;
  EXPECT_EQ(ReadFile(folder_ / "dense" / "fused.ply"), points);
  EXPECT_EQ(WriteTimes(folder_ / "dense" / "builtin"), times) << "depth maps were made again";
}

TEST_F(DenseReconstructorCommand, DepthMapsAgainstThemselvesArePerfect) {
  ASSERT_EQ(Run(DenseArguments()).exit_code, 0);
  const std::string maps = Path("dense/stereo/depth_maps");
  const ChildProcessResult evaluation =
      Run({"model_evaluator", "--depth_path", maps, "--ground_truth_path", maps, "--output_path",
           Path("depth.json")});
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.output;
  const auto json = nlohmann::json::parse(ReadFile(folder_ / "depth.json"));
  EXPECT_EQ(json.at("valid_share").get<double>(), 1.0);
  EXPECT_EQ(json.at("relative_error").at("percentile99").get<double>(), 0.0);
}

TEST_F(DenseReconstructorCommand, BadInputIsOneClearLine) {
  std::vector<std::string> arguments = DenseArguments();
  arguments[2] = "magic";
  ExpectFailure(Run(arguments), 2, {"magic", "builtin"});
  arguments = DenseArguments();
  arguments.insert(arguments.end(), {"--texture", "maybe"});
  ExpectFailure(Run(arguments), 2, {"--texture", "maybe", "auto"});
  std::filesystem::remove(folder_ / "images" / "photo_103.png");
  ExpectFailure(Run(DenseArguments()), 1, {"photo_103.png"});
  ExpectFailure(Run({"model_evaluator", "--mesh_path", Path("images"), "--ground_truth_path",
                     Path("truth.ply"), "--output_path", Path("e.json")}),
                1, {"images", "meshed-poisson.ply"});
}

}  // namespace
}  // namespace colmap_ext
