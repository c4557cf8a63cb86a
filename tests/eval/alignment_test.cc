#include "colmap_ext/eval/alignment.h"

#include <gtest/gtest.h>

#include "colmap_ext/util/error.h"
#include "eval/shapes.h"

namespace colmap_ext {
namespace {

const Sim3d kFarSim3 = MakeSim3(0.37, 1.1, {1, -2, 0.5}, {120, -45, 8});

std::vector<CameraPair> MakePairs(const Sim3d& truth_from_model, int count) {
  std::vector<CameraPair> pairs;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-10, 10);
  for (int i = 0; i < count; ++i) {
    CameraPair pair;
    pair.name = "photo" + std::to_string(100 + i);
    for (int k = 0; k < 3; ++k) pair.center_in_model[k] = uniform(random);
    pair.center_in_truth = truth_from_model * pair.center_in_model;
    pairs.push_back(pair);
  }
  return pairs;
}

// Largest distance between what two transforms make of the corners of a 10 m box.
double Difference(const Sim3d& a, const Sim3d& b) {
  double largest = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(10.0 * (i & 1), 5.0 * (i & 2), 2.5 * (i & 4));
    largest = std::max(largest, (a * corner - b * corner).norm());
  }
  return largest;
}

TEST(AlignByCameras, KnownSimilarityComesBack) {
  const CameraAlignment alignment = AlignByCameras(MakePairs(kFarSim3, 12));
  EXPECT_LT(Difference(alignment.truth_from_model, kFarSim3), 1e-10);
  EXPECT_LT(alignment.rms_m, 1e-10);
  EXPECT_TRUE(alignment.rejected.empty());
}

TEST(AlignByCameras, OneWronglyRegisteredPhotoDoesNotBendTheFrame) {
  std::vector<CameraPair> pairs = MakePairs(kFarSim3, 12);
  pairs[4].center_in_model += Eigen::Vector3d(6, -3, 2);
  const CameraAlignment alignment = AlignByCameras(pairs);
  EXPECT_LT(Difference(alignment.truth_from_model, kFarSim3), 1e-9);
  EXPECT_EQ(alignment.rejected, std::vector<std::string>{"photo104"});
}

TEST(AlignByCameras, TooFewOrCollinearPhotosAreRefused) {
  EXPECT_THROW(AlignByCameras(MakePairs(kFarSim3, 2)), Error);
  std::vector<CameraPair> line(5);
  for (int i = 0; i < 5; ++i) {
    line[static_cast<std::size_t>(i)].center_in_model = Eigen::Vector3d(i, 2 * i, 0);
    line[static_cast<std::size_t>(i)].center_in_truth = Eigen::Vector3d(i, 2 * i, 1);
  }
  EXPECT_THROW(AlignByCameras(line), Error);
}

TEST(PairCameras, MatchesByName) {
  Reconstruction model;
  model.images[7].name = "b.jpg";
  model.images[7].cam_from_world.translation = Eigen::Vector3d(0, 0, -3);
  model.images[9].name = "a.jpg";
  model.images[11].name = "only_in_model.jpg";
  std::map<std::string, Rigid3d> truth{{"a.jpg", {}}, {"b.jpg", {}}, {"only_in_truth.jpg", {}}};
  truth["b.jpg"].translation = Eigen::Vector3d(1, 0, 0);
  const auto pairs = PairCameras(model, truth);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].name, "a.jpg");
  EXPECT_EQ(pairs[1].center_in_model, Eigen::Vector3d(0, 0, 3));
  EXPECT_EQ(pairs[1].center_in_truth, Eigen::Vector3d(-1, 0, 0));
}

TEST(RefineByIcp, KnownSimilarityComesBackAt1e6) {
  const TriangleMesh truth = House();
  const Sim3d moved = MakeSim3(1.03, 0.04, {1, 2, 3}, {0.15, -0.1, 0.2});
  const IcpResult result = RefineByIcp(TransformMesh(moved, truth), truth, {}, {}, {});
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.start_rms_m, 0.05);
  EXPECT_LT(result.rms_m, 1e-7);
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 1e-6);
}

TEST(RefineByIcp, CamerasThenIcpFromFarAway) {
  const TriangleMesh truth = House();
  const Sim3d model_from_truth = Inverse(kFarSim3);
  std::vector<CameraPair> pairs = MakePairs(kFarSim3, 12);
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.05);
  for (auto& pair : pairs) {
    for (int k = 0; k < 3; ++k) pair.center_in_truth[k] += noise(random);
  }
  const Sim3d start = AlignByCameras(pairs).truth_from_model;
  EXPECT_GT(Difference(start * model_from_truth, {}), 1e-3);
  const IcpResult result =
      RefineByIcp(TransformMesh(model_from_truth, truth), truth, start, {}, {});
  EXPECT_LT(Difference(result.truth_from_model * model_from_truth, {}), 1e-6);
}

TEST(RefineByIcp, HolesAndSurroundingGroundDoNotPull) {
  const TriangleMesh truth = House();
  TriangleMesh model;
  AppendRectangle({-30, -30, -0.3}, {60, 0, 0}, {0, 60, 0}, 20, &model);  // not in the truth
  const std::size_t ground_faces = model.faces.size();
  AppendBox({0, 0, 0}, {8, 5, 4}, 12, &model);
  AppendBox({8, 1, 0}, {2.5, 2, 9}, 12, &model);
  // A hole in the first wall of the house (in x = 0 … 4 of y = 0).
  std::erase_if(model.faces, [&](const Eigen::Vector3i& face) {
    const Eigen::Vector3d& corner = model.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3d& other = model.vertices[static_cast<std::size_t>(face[1])];
    const Eigen::Vector3d& third = model.vertices[static_cast<std::size_t>(face[2])];
    return corner.y() == 0 && other.y() == 0 && third.y() == 0 && corner.x() < 4 &&
           corner.z() > 0.5;
  });
  ASSERT_GT(model.faces.size(), ground_faces);
  const Sim3d moved = MakeSim3(0.98, 0.02, {0, 1, 1}, {0.1, 0.05, -0.1});
  const IcpResult result = RefineByIcp(TransformMesh(moved, model), truth, {}, {}, {});
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 1e-4);
}

// A flat roof with a box on it, over a floor.
TriangleMesh Canopy() {
  TriangleMesh mesh;
  AppendBox({0, 0, 6}, {14, 10, 0.4}, 20, &mesh);
  AppendBox({3, 2, 6.4}, {8, 6, 2}, 20, &mesh);
  AppendBox({-2, -2, -0.3}, {18, 14, 0.3}, 20, &mesh);
  return mesh;
}

TEST(RefineByIcp, WhatNoPhotoSawDoesNotPull) {
  TriangleMesh truth = Canopy();
  AppendBox({1, 1, 0}, {12, 8, 6}, 20, &truth);  // rooms behind walls that the model has not
  TriangleMesh model = Canopy();
  // Only what looks up or to the side was seen; below the roof a surface sags, as Poisson's do.
  for (Eigen::Vector3d& vertex : model.vertices) {
    if (vertex.z() == 6) vertex.z() = 5.6;
  }
  const Sim3d moved = MakeSim3(1.004, 0.005, {1, 0, 1}, {0.04, -0.03, 0.05});
  const IcpResult result = RefineByIcp(TransformMesh(moved, model), truth, {}, {}, {});
  EXPECT_NEAR(result.truth_from_model.scale * moved.scale, 1, 5e-4);
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 0.01);
}

// Seen from above only: the roof is right, and what hangs below it is 0.6 m off on all sides.
TEST(RefineByIcp, AStartThatIsKnownToBeGoodIsNotLeftForWhatIsMissing) {
  TriangleMesh truth = Canopy();
  AppendBox({1, 1, 0}, {12, 8, 6}, 20, &truth);
  TriangleMesh model;
  AppendBox({0, 0, 6.2}, {14, 10, 0.2}, 20, &model);
  AppendBox({0.4, 0.4, 0.6}, {13.2, 9.2, 5}, 20, &model);
  const Sim3d moved = MakeSim3(1.0002, 0.0002, {1, 0, 1}, {0.004, -0.003, 0.005});
  IcpOptions options;
  options.start_error_m = 0.01;
  const IcpResult result = RefineByIcp(TransformMesh(moved, model), truth, {}, options, {});
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 0.01);
  const IcpResult unaware = RefineByIcp(TransformMesh(moved, model), truth, {}, {}, {});
  EXPECT_GT(Difference(unaware.truth_from_model * moved, {}), 0.5) << "else this shows nothing";
  options.start_error_m = -1;
  EXPECT_THROW(RefineByIcp(model, truth, {}, options, {}), UsageError);
}

TEST(RefineByIcp, TruthWoundTheOtherWayRound) {
  TriangleMesh truth = House();
  for (Eigen::Vector3i& face : truth.faces) std::swap(face[1], face[2]);
  const Sim3d moved = MakeSim3(1.03, 0.04, {1, 2, 3}, {0.15, -0.1, 0.2});
  const IcpResult result = RefineByIcp(TransformMesh(moved, House()), truth, {}, {}, {});
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 1e-6);
}

TEST(RefineByIcp, WithoutScaleTheScaleStays) {
  const TriangleMesh truth = House();
  IcpOptions options;
  options.with_scale = false;
  const Sim3d moved = MakeSim3(1.0, 0.03, {1, 0, 3}, {0.1, -0.1, 0.1});
  const IcpResult result = RefineByIcp(TransformMesh(moved, truth), truth, {}, options, {});
  EXPECT_EQ(result.truth_from_model.scale, 1.0);
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 1e-6);
}

TEST(RefineByIcp, WhatTheShapeDoesNotDetermineStays) {
  TriangleMesh plane;
  AppendRectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 10, &plane);
  const Sim3d lifted = MakeSim3(1, 0, {0, 0, 1}, {0, 0, 0.2});
  const IcpResult result = RefineByIcp(TransformMesh(lifted, plane), plane, {}, {}, {});
  const Eigen::Vector3d corner = result.truth_from_model * (lifted * Eigen::Vector3d(4, 4, 0));
  EXPECT_LT((corner - Eigen::Vector3d(4, 4, 0)).norm(), 1e-9);
}

TEST(RefineByIcp, CloudAgainstMesh) {
  const TriangleMesh truth = House();
  TriangleMesh cloud;
  for (const auto& sample : SampleUniformly(truth, 60000, 9)) {
    cloud.vertices.push_back(sample.position);
  }
  const Sim3d moved = MakeSim3(1.01, 0.02, {1, 2, 3}, {0.05, -0.05, 0.1});
  const IcpResult result = RefineByIcp(TransformMesh(moved, cloud), truth, {}, {}, {});
  EXPECT_LT(Difference(result.truth_from_model * moved, {}), 0.01);
}

TEST(RefineByIcp, ClearErrors) {
  const TriangleMesh truth = House();
  EXPECT_THROW(RefineByIcp({}, truth, {}, {}, {}), Error);
  EXPECT_THROW(RefineByIcp(truth, {}, {}, {}, {}), Error);
  const Sim3d far_away = MakeSim3(1, 0, {0, 0, 1}, {1000, 0, 0});
  EXPECT_THROW(RefineByIcp(TransformMesh(far_away, truth), truth, {}, {}, {}), Error);
  IcpOptions options;
  options.trim = 1.5;
  EXPECT_THROW(RefineByIcp(truth, truth, {}, options, {}), UsageError);
}

}  // namespace
}  // namespace colmap_ext
