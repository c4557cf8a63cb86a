// Our distances against those of an independent library.
#include <gtest/gtest.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/t/geometry/RaycastingScene.h>
#include <open3d/t/geometry/TriangleMesh.h>
#include <open3d/utility/Random.h>

#include <cmath>
#include <numeric>

#include "colmap_ext/eval/evaluate.h"
#include "eval/shapes.h"

namespace colmap_ext {
namespace {

// The house with waves of 5 cm, so that errors are of every size.
TriangleMesh WavyHouse(int n) {
  TriangleMesh mesh = House(n);
  for (Eigen::Vector3d& vertex : mesh.vertices) {
    vertex += 0.05 * Eigen::Vector3d(std::sin(3 * vertex.z()), std::sin(2 * vertex.x() + 1),
                                     std::sin(2.5 * vertex.y()));
  }
  return mesh;
}

open3d::geometry::PointCloud ToCloud(const std::vector<Eigen::Vector3d>& points) {
  return open3d::geometry::PointCloud(points);
}

double MeanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double ShareBelow(const std::vector<double>& values, double limit) {
  double below = 0;
  for (const double value : values) below += value < limit ? 1 : 0;
  return below / static_cast<double>(values.size());
}

TEST(AgainstOpen3d, DistancesToVerticesAreTheSame) {
  EvaluationOptions options;
  options.distance = "vertex";
  const TriangleMesh model = WavyHouse(40);
  const EvaluationResult result = EvaluateModel(model, House(), options, {});
  std::vector<Eigen::Vector3d> positions;
  for (const auto& sample : result.truth_samples) positions.push_back(sample.position);
  const auto theirs = ToCloud(positions).ComputePointCloudDistance(ToCloud(model.vertices));
  ASSERT_EQ(theirs.size(), result.truth_error_m.size());
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    ASSERT_NEAR(theirs[i], result.truth_error_m[i], 1e-9);
  }
}

// Distances of points to the surface of a mesh.
std::vector<double> SurfaceDistances(const open3d::geometry::TriangleMesh& mesh,
                                     const std::vector<Eigen::Vector3d>& points) {
  open3d::t::geometry::RaycastingScene scene;
  scene.AddTriangles(open3d::t::geometry::TriangleMesh::FromLegacy(mesh));
  std::vector<float> queries;
  for (const Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) queries.push_back(static_cast<float>(point[k]));
  }
  const open3d::core::Tensor tensor(queries, {static_cast<std::int64_t>(points.size()), 3},
                                    open3d::core::Float32);
  const std::vector<float> distances = scene.ComputeDistance(tensor).ToFlatVector<float>();
  return {distances.begin(), distances.end()};
}

TEST(AgainstOpen3d, ErrorAndCompletenessWithinOnePercent) {
  // Open3D samples the truth in its own way and measures by its own ray caster.
  const TriangleMesh model = WavyHouse(40);
  const TriangleMesh truth = House();
  EvaluationOptions options;
  options.sample_spacing_m = 0.06;
  const EvaluationResult ours = EvaluateModel(model, truth, options, {});
  open3d::utility::random::Seed(5);
  const open3d::geometry::TriangleMesh their_model(model.vertices, model.faces);
  open3d::geometry::TriangleMesh their_truth(truth.vertices, truth.faces);
  const auto samples = their_truth.SamplePointsUniformly(200000);
  const std::vector<double> theirs = SurfaceDistances(their_model, samples->points_);
  EXPECT_NEAR(ours.errors.mean_m, MeanOf(theirs), 0.01 * MeanOf(theirs));
  EXPECT_NEAR(ours.scores[0].completeness, ShareBelow(theirs, 0.0254), 0.01);
  EXPECT_NEAR(ours.scores[1].completeness, ShareBelow(theirs, 0.0508), 0.01);
}

}  // namespace
}  // namespace colmap_ext
