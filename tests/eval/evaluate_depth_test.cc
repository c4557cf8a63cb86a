#include "colmap_ext/eval/evaluate_depth.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

DenseMap Map(const std::vector<float>& data) {
  DenseMap map(static_cast<int>(data.size()) / 2, 2, 1);
  map.data = data;
  return map;
}

TEST(DepthEvaluator, CountsAndErrorsOfKnownMaps) {
  DepthEvaluator evaluator;
  // Truth: no surface in the last two pixels. Map: one hole, one depth where nothing is.
  evaluator.Add("a", Map({10.1f, 9.9f, 0, 12.5f, 3, 0}), Map({10, 10, 10, 10, 0, 0}), nullptr);
  const DepthEvaluation result = evaluator.Result();
  EXPECT_EQ(result.truth_pixels, 4u);
  EXPECT_EQ(result.valid_pixels, 3u);
  EXPECT_EQ(result.false_pixels, 1u);
  EXPECT_DOUBLE_EQ(result.valid_share, 0.75);
  EXPECT_NEAR(result.mean, (0.01 + 0.01 + 0.25) / 3, 1e-6);
  EXPECT_NEAR(result.median, 0.01, 1e-6);
  EXPECT_NEAR(result.percentile90, 0.25, 1e-6);
  EXPECT_NEAR(result.within_5_percent, 2.0 / 3, 1e-12);
  EXPECT_NEAR(result.mean_error_m, (0.1 + 0.1 + 2.5) / 3, 1e-6);
  EXPECT_TRUE(result.by_confidence.empty());
}

TEST(DepthEvaluator, ErrorsByConfidenceOverSeveralMaps) {
  DepthEvaluator evaluator;
  const DenseMap first_confidence = Map({0.95f, 0.91f});
  const DenseMap second_confidence = Map({0.05f, 1.0f});
  evaluator.Add("a", Map({10.1f, 10.3f}), Map({10, 10}), &first_confidence);
  evaluator.Add("b", Map({15.0f, 10.2f}), Map({10, 10}), &second_confidence);
  const auto bins = evaluator.Result().by_confidence;
  ASSERT_EQ(bins.size(), 10u);
  EXPECT_EQ(bins[0].pixels, 1u);
  EXPECT_NEAR(bins[0].mean, 0.5, 1e-6);
  EXPECT_EQ(bins[9].pixels, 3u);
  EXPECT_NEAR(bins[9].mean, 0.02, 1e-6);
  EXPECT_NEAR(bins[9].median, 0.02, 1e-6);
  EXPECT_EQ(bins[5].pixels, 0u);
  const auto json = nlohmann::json::parse(DepthEvaluationToJson(evaluator.Result()));
  EXPECT_EQ(json.at("by_confidence").size(), 10u);
  EXPECT_NEAR(json.at("relative_error").at("mean").get<double>(), 0.14, 1e-6);
}

TEST(DepthEvaluator, RefusesWhatDoesNotCorrespond) {
  DepthEvaluator evaluator;
  EXPECT_THROW(evaluator.Result(), Error);
  EXPECT_THROW(evaluator.Add("a", Map({1, 2, 3, 4}), Map({1, 2}), nullptr), Error);
  const DenseMap confidence = Map({1, 1});
  evaluator.Add("a", Map({1, 2}), Map({1, 2}), &confidence);
  EXPECT_THROW(evaluator.Add("b", Map({1, 2}), Map({1, 2}), nullptr), Error);
  EXPECT_THROW(evaluator.Add("b", DenseMap(1, 2, 3), DenseMap(1, 2, 3), &confidence), Error);
}

TEST(DepthEvaluator, NoDepthAtAllIsAnAnswer) {
  DepthEvaluator evaluator;
  evaluator.Add("a", Map({0, 0}), Map({10, 10}), nullptr);
  const DepthEvaluation result = evaluator.Result();
  EXPECT_EQ(result.valid_share, 0);
  EXPECT_EQ(result.median, 0);
}

}  // namespace
}  // namespace colmap_ext
