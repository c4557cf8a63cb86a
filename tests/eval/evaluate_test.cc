#include "colmap_ext/eval/evaluate.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/error.h"
#include "eval/shapes.h"

namespace colmap_ext {
namespace {

TriangleMesh Plane(double side, int n, double z = 0) {
  TriangleMesh mesh;
  AppendRectangle({0, 0, z}, {side, 0, 0}, {0, side, 0}, n, &mesh);
  return mesh;
}

EvaluationOptions FineOptions() {
  EvaluationOptions options;
  options.sample_spacing_m = 0.03;
  return options;
}

TEST(EvaluateModel, TruthAgainstItselfIsPerfect) {
  const EvaluationResult result = EvaluateModel(House(), House(), {}, {});
  EXPECT_LT(result.errors.rms_m, 1e-12);
  ASSERT_EQ(result.scores.size(), 2u);
  for (const ThresholdScore& score : result.scores) {
    EXPECT_EQ(score.completeness, 1.0);
    EXPECT_EQ(score.accuracy, 1.0);
    EXPECT_EQ(score.f_score, 1.0);
  }
}

TEST(EvaluateModel, KnownOffsetGivesThatError) {
  const EvaluationResult result = EvaluateModel(Plane(3, 1, 0.03), Plane(3, 1), {}, {});
  EXPECT_NEAR(result.errors.mean_m, 0.03, 1e-12);
  EXPECT_NEAR(result.errors.rms_m, 0.03, 1e-12);
  EXPECT_NEAR(result.errors.median_m, 0.03, 1e-12);
  EXPECT_EQ(result.scores[0].completeness, 0.0);  // 25.4 mm
  EXPECT_EQ(result.scores[0].f_score, 0.0);
  EXPECT_EQ(result.scores[1].completeness, 1.0);  // 50.8 mm
  EXPECT_EQ(result.scores[1].accuracy, 1.0);
}

TEST(EvaluateModel, HoleOfKnownAreaGivesExpectedCompleteness) {
  // A 1 m x 1 m hole in a 4 m x 4 m plane: what lies deeper than d inside the hole is missing.
  TriangleMesh model = Plane(4, 8);
  std::erase_if(model.faces, [&](const Eigen::Vector3i& face) {
    const Eigen::Vector3d center = (model.vertices[static_cast<std::size_t>(face[0])] +
                                    model.vertices[static_cast<std::size_t>(face[1])] +
                                    model.vertices[static_cast<std::size_t>(face[2])]) /
                                   3;
    return center.x() > 1.5 && center.x() < 2.5 && center.y() > 1 && center.y() < 2;
  });
  const EvaluationResult result = EvaluateModel(model, Plane(4, 8), FineOptions(), {});
  for (const ThresholdScore& score : result.scores) {
    const double missing = std::pow(1 - 2 * score.threshold_m, 2) / 16;
    EXPECT_NEAR(score.completeness, 1 - missing, 0.002) << score.threshold_m;
    EXPECT_EQ(score.accuracy, 1.0);
  }
  // Mean distance to the border of a unit square is 1/6, over 1/16 of the area.
  EXPECT_NEAR(result.errors.mean_m, 1.0 / 6 / 16, 0.0005);
}

TEST(EvaluateModel, CapLimitsWhatAHoleCosts) {
  TriangleMesh model = Plane(4, 2);
  std::erase_if(model.faces, [&](const Eigen::Vector3i& face) {
    return model.vertices[static_cast<std::size_t>(face[0])].x() == 2;  // half of the plane
  });
  EvaluationOptions options = FineOptions();
  options.cap_m = 0.1;
  const EvaluationResult result = EvaluateModel(model, Plane(4, 2), options, {});
  EXPECT_NEAR(result.errors.mean_m, 0.5, 0.01);              // 0 … 2 m over half of the area
  EXPECT_NEAR(result.errors.capped_mean_m, 0.04875, 0.002);  // (0.05 · 0.1 + 0.1 · 1.9) / 4
  EXPECT_LT(result.errors.capped_rms_m, 0.1);
}

TEST(EvaluateModel, VertexDistanceIsThePapers) {
  // Vertices every 0.5 m: a sample in the middle of a cell is far from all of them.
  EvaluationOptions options = FineOptions();
  options.distance = "vertex";
  const EvaluationResult result = EvaluateModel(Plane(2, 4), Plane(2, 4), options, {});
  // Mean distance to the nearest corner of a square cell of side a: a · 0.3826.
  EXPECT_NEAR(result.errors.mean_m, 0.5 * 0.38260, 0.003);
  TriangleMesh cloud = Plane(2, 4);
  cloud.faces.clear();
  const EvaluationResult from_cloud = EvaluateModel(cloud, Plane(2, 4), FineOptions(), {});
  EXPECT_EQ(from_cloud.errors.mean_m, result.errors.mean_m);
  EXPECT_EQ(from_cloud.scores[0].accuracy, 1.0);
}

TEST(EvaluateModel, GroundAroundTheObjectIsNoError) {
  TriangleMesh model = House();
  AppendRectangle({-50, -50, 0}, {120, 0, 0}, {0, 120, 0}, 10, &model);
  const EvaluationResult result = EvaluateModel(model, House(), {}, {});
  EXPECT_LT(result.scores[0].accuracy, 0.95);  // ground within the margin counts …
  EvaluationOptions options;
  options.ground_cut_m = 0.1;
  const EvaluationResult cut = EvaluateModel(model, House(), options, {});
  EXPECT_EQ(cut.scores[0].accuracy, 1.0);  // … unless it is cut away
  for (const auto& sample : cut.truth_samples) EXPECT_GE(sample.position.z(), 0.1);
}

TEST(EvaluateModel, RegionRestrictsBothSides) {
  TriangleMesh model = House();
  for (auto& vertex : model.vertices) {
    if (vertex.x() > 8.5) vertex.x() += 0.2;  // the far side of the tower is wrong
  }
  const BoundingBox house(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(7.9, 6, 5));
  const EvaluationResult result = EvaluateModel(model, House(), {}, {}, house);
  EXPECT_EQ(result.scores[0].completeness, 1.0);
  EXPECT_EQ(result.scores[0].accuracy, 1.0);
  EXPECT_LT(EvaluateModel(model, House(), {}, {}).scores[0].completeness, 0.95);
  const BoundingBox nowhere(Eigen::Vector3d(100, 100, 100), Eigen::Vector3d(101, 101, 101));
  EXPECT_THROW(EvaluateModel(model, House(), {}, {}, nowhere), Error);
}

TEST(EvaluateModel, AgreesWithRayScene) {
  TriangleMesh model = House(5);
  for (std::size_t i = 0; i < model.vertices.size(); ++i) {
    model.vertices[i].z() += 0.1 * std::sin(static_cast<double>(i));
  }
  const EvaluationResult result = EvaluateModel(model, House(), {}, {});
  const RayScene scene(model);
  for (std::size_t i = 0; i < result.truth_samples.size(); i += 97) {
    EXPECT_NEAR(scene.DistanceToSurface(result.truth_samples[i].position, 10),
                result.truth_error_m[i], 1e-5);
  }
}

// A laser scan: points of the house's surface, 8 cm apart.
TriangleMesh ScanOfHouse() {
  TriangleMesh scan;
  for (const auto& sample : SamplePoissonDisk(House(), 0.08, 3)) {
    scan.vertices.push_back(sample.position);
  }
  return scan;
}

TEST(EvaluateModel, TruthMayBeAScan) {
  TriangleMesh model = House();
  for (auto& vertex : model.vertices) vertex *= 1.01;
  EvaluationOptions options;
  options.sample_spacing_m = 0.2;
  const EvaluationResult by_scan = EvaluateModel(model, ScanOfHouse(), options, {});
  const EvaluationResult by_mesh = EvaluateModel(model, House(), options, {});
  EXPECT_NEAR(by_scan.errors.mean_m, by_mesh.errors.mean_m, 0.03 * by_mesh.errors.mean_m);
  EXPECT_NEAR(by_scan.scores[1].completeness, by_mesh.scores[1].completeness, 0.03);
  // Samples of a scan are its own points, no two nearer than the spacing.
  for (std::size_t i = 1; i < by_scan.truth_samples.size(); ++i) {
    const auto& a = by_scan.truth_samples[i - 1].position;
    ASSERT_GE((a - by_scan.truth_samples[i].position).norm(), options.sample_spacing_m);
  }
}

TEST(AlignModel, ComesBackToAScan) {
  const Sim3d moved = MakeSim3(1.03, 0.02, {0.3, 0.2, 1}, {0.08, -0.05, 0.03});
  EvaluationOptions options;
  options.icp.num_samples = 5000;
  const TriangleMesh model = TransformMesh(moved, House());
  const ModelAlignment alignment = AlignModel(model, ScanOfHouse(), {}, options, {});
  EXPECT_NEAR(alignment.truth_from_model.scale * moved.scale, 1, 1e-4);
  EXPECT_LT(alignment.icp->rms_m, 1e-3);
}

TEST(EvaluateModel, BadInput) {
  EXPECT_THROW(EvaluateModel({}, House(), {}, {}), Error);
  EXPECT_THROW(EvaluateModel(House(), {}, {}, {}), Error);
  EvaluationOptions options;
  options.distance = "hausdorff";
  EXPECT_THROW(EvaluateModel(House(), House(), options, {}), UsageError);
}

TEST(EvaluationOptions, CheckNamesTheField) {
  EvaluationOptions options;
  EXPECT_EQ(options.Check(), "");
  options.thresholds = "25.4;50.8";
  EXPECT_NE(options.Check().find("thresholds"), std::string::npos);
  options.thresholds = "10,-3";
  EXPECT_NE(options.Check().find("-3"), std::string::npos);
  options.thresholds = "50, 10 mm,3cm,0.2m";
  EXPECT_EQ(options.ThresholdsM(), (std::vector<double>{0.010, 0.03, 0.050, 0.2}));
  options.thresholds = "1in,2in";
  EXPECT_EQ(options.ThresholdsM(), (std::vector<double>{0.0254, 0.0508}));
  options.thresholds = "3 feet";
  EXPECT_NE(options.Check().find("3 feet"), std::string::npos);
  options.thresholds = "10";
  options.icp.trim = 0.95;
  EXPECT_NE(options.Check().find("icp_trim"), std::string::npos);
  options = {};
  options.sample_spacing_m = std::nan("");
  EXPECT_NE(options.Check().find("sample_spacing_m"), std::string::npos);
}

TEST(EvaluationToJson, HasTheDocumentedNames) {
  const TriangleMesh truth = House();
  const Sim3d moved = MakeSim3(1.02, 0.01, {0, 0, 1}, {0.05, 0, 0});
  const TriangleMesh model = TransformMesh(moved, truth);
  EvaluationOptions options;
  const ModelAlignment alignment = AlignModel(model, truth, {}, options, {});
  const EvaluationResult result =
      EvaluateModel(TransformMesh(alignment.truth_from_model, model), truth, options, {});
  const auto json = nlohmann::json::parse(EvaluationToJson(result, alignment, options));
  EXPECT_NEAR(json.at("scale").get<double>(), 1 / 1.02, 1e-6);
  EXPECT_NEAR(json.at("mean_error_m").get<double>(), 0, 1e-6);
  EXPECT_NEAR(json.at("rms_error_m").get<double>(), 0, 1e-6);
  for (const char* name : {"completeness", "accuracy", "f_score"}) {
    EXPECT_EQ(json.at(name).at("25.4mm").get<double>(), 1.0) << name;
    EXPECT_EQ(json.at(name).at("50.8mm").get<double>(), 1.0) << name;
  }
  EXPECT_EQ(json.at("samples").get<std::size_t>(), result.truth_samples.size());
  EXPECT_TRUE(json.at("alignment").at("icp").at("converged").get<bool>());
  EXPECT_FALSE(json.at("alignment").contains("cameras"));
}

TEST(DistancesTo, KnownDistances) {
  const std::vector<double> distances =
      DistancesTo(Plane(2, 1), {{1, 1, 2}, {1, 1, -3}, {-3, -4, 0}});
  ASSERT_EQ(distances.size(), 3u);
  EXPECT_NEAR(distances[0], 2, 1e-12);
  EXPECT_NEAR(distances[1], 3, 1e-12);
  EXPECT_NEAR(distances[2], 5, 1e-12);
  EXPECT_THROW(DistancesTo({}, {{0, 0, 0}}), Error);
}

TEST(AlignModel, WithoutIcpAndCamerasNothingMoves) {
  EvaluationOptions options;
  options.icp.max_iterations = 0;
  const ModelAlignment alignment = AlignModel(House(), House(), {}, options, {});
  EXPECT_EQ(alignment.truth_from_model.scale, 1.0);
  EXPECT_FALSE(alignment.icp);
}

}  // namespace
}  // namespace colmap_ext
