#include "colmap_ext/eval/count_views.h"

#include <gtest/gtest.h>

#include <cmath>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/util/error.h"
#include "eval/shapes.h"

namespace colmap_ext {
namespace {

// A camera 20 m before the middle of the house's front (y = 0), 60 degrees wide.
Reconstruction FrontCameras(int count) {
  Reconstruction model;
  model.cameras[1] = {CameraModel::kSimplePinhole, 800, 600, {700, 400, 300}};
  for (int i = 0; i < count; ++i) {
    SparseImage image;
    image.name = std::to_string(i);
    image.camera_id = 1;
    image.cam_from_world = CamFromWorld({4.0 + i, -20, 2}, {0, 0});  // looks north
    model.images[static_cast<ImageId>(i + 1)] = image;
  }
  return model;
}

TEST(CountViews, FrontIsSeenAndBackIsNot) {
  const TriangleMesh house = House();
  EvaluationOptions options;
  options.sample_spacing_m = 0.3;
  EvaluationResult result = EvaluateModel(house, house, options, {});
  const auto views = CountViews(result.truth_samples, house, FrontCameras(2), {}, {});
  int front = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const SurfaceSample& sample = result.truth_samples[i];
    if (sample.normal.y() > 0.5) {
      EXPECT_EQ(views[i], 0) << "behind";
    }
    if (sample.normal.y() < -0.5 && sample.position.y() < 0.01) {
      EXPECT_EQ(views[i], 2);
      ++front;
    }
  }
  EXPECT_GT(front, 100);
  SplitBySeen(views, options, &result);
  EXPECT_EQ(result.seen->samples + result.unseen->samples, views.size());
  EXPECT_GE(result.seen->samples, static_cast<std::size_t>(front));
  EXPECT_GT(result.unseen->samples, 0u);
  EXPECT_EQ(result.seen->completeness[0], 1.0);
}

TEST(CountViews, WallHidesWhatIsBehindIt) {
  TriangleMesh truth;
  AppendRectangle({0, 0, 0}, {8, 0, 0}, {0, 0, 4}, 4, &truth);   // looks south
  AppendRectangle({0, -5, 0}, {4, 0, 0}, {0, 0, 8}, 4, &truth);  // hides its western half
  EvaluationOptions options;
  options.sample_spacing_m = 0.2;
  const auto samples = EvaluateModel(truth, truth, options, {}).truth_samples;
  const auto views = CountViews(samples, truth, FrontCameras(1), {}, {});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].position.y() < -1) continue;
    const double x = samples[i].position.x();
    if (std::abs(x - 4) < 0.1) continue;
    EXPECT_EQ(views[i], x < 4 ? 0 : 1) << samples[i].position.transpose();
  }
}

TEST(CountViews, CamerasAreMovedIntoTheTruthsFrame) {
  const TriangleMesh house = House();
  EvaluationOptions options;
  options.sample_spacing_m = 0.5;
  const auto samples = EvaluateModel(house, house, options, {}).truth_samples;
  const Sim3d moved = MakeSim3(0.3, 1.0, {1, 2, 3}, {100, -50, 7});
  Reconstruction model = FrontCameras(3);
  TransformReconstruction(moved, &model);
  EXPECT_EQ(CountViews(samples, house, model, Inverse(moved), {}),
            CountViews(samples, house, FrontCameras(3), {}, {}));
}

TEST(CountViews, CloudHidesNothingAndIsRefused) {
  TriangleMesh cloud = House();
  cloud.faces.clear();
  EXPECT_THROW(CountViews({}, cloud, FrontCameras(1), {}, {}), Error);
}

}  // namespace
}  // namespace colmap_ext
