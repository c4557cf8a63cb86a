#include "colmap_ext/session/session_options.h"

#include <gtest/gtest.h>

#include "colmap_ext/session/presets.h"
#include "colmap_ext/session/session.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

TEST(StageOptions, DefaultsAreValidAndBoundOnce) {
  StageOptions options;
  EXPECT_EQ(options.Check(), "");
  OptionSet set;
  EXPECT_NO_THROW(BindOptions(set, &options));  // throws when a name is declared twice
  EXPECT_NE(set.ToIni().find("[NextBestView]"), std::string::npos);
}

TEST(StageOptions, IndoorPresetIsValidAndSmaller) {
  StageOptions options;
  OptionSet set;
  BindOptions(set, &options);
  set.Parse({"--Path.cell_size_m", "0.3"});
  ApplyPreset("indoor", set, &options);
  EXPECT_EQ(options.Check(), "");
  EXPECT_LT(options.coverage.ground_sampling_distance_mm, 10);
  EXPECT_LT(options.nbv.safe_distance_m, 1);
  EXPECT_EQ(options.path.cell_size_m, 0.3) << "what the user set stays";
  EXPECT_THROW(ApplyPreset("underwater", set, &options), UsageError);
}

TEST(StageOptions, FitToSiteScalesDistancesButNotSafety) {
  StageOptions options;
  const double gsd_mm = 3 * options.coverage.ground_sampling_distance_mm;
  const StageOptions fitted = FitToSite(options, gsd_mm);
  EXPECT_EQ(fitted.Check(), "");
  EXPECT_DOUBLE_EQ(fitted.coverage.ground_sampling_distance_mm, gsd_mm);
  EXPECT_DOUBLE_EQ(fitted.nbv.grid_spacing_m, 3 * options.nbv.grid_spacing_m);
  EXPECT_DOUBLE_EQ(fitted.path.cell_size_m, 3 * options.path.cell_size_m);
  EXPECT_EQ(fitted.nbv.safe_distance_m, options.nbv.safe_distance_m);
  EXPECT_EQ(fitted.path.safe_distance_m, options.path.safe_distance_m);
}

TEST(SessionOptions, CheckNamesTheOption) {
  SessionOptions options;
  options.max_iterations = 0;
  EXPECT_NE(options.Check().find("max_iterations"), std::string::npos);
  options = {};
  options.target_covered_ratio = 1.5;
  EXPECT_NE(options.Check().find("target_covered_ratio"), std::string::npos);
  options = {};
  options.max_image_size_px = 10;
  EXPECT_NE(options.Check().find("max_image_size_px"), std::string::npos);
}

TEST(SessionInputs, NeedsExactlyOneSourceOfPhotos) {
  SessionInputs inputs;
  inputs.workspace_path = "w";
  EXPECT_THROW(inputs.Check(), UsageError);
  inputs.scene = "church";
  EXPECT_NO_THROW(inputs.Check());
  inputs.image_path = testing::TempDir();
  EXPECT_THROW(inputs.Check(), UsageError);
  inputs.scene.clear();
  EXPECT_NO_THROW(inputs.Check());
  inputs.sparse_path = testing::TempDir();
  EXPECT_THROW(inputs.Check(), UsageError) << "a model without its database";
}

}  // namespace
}  // namespace colmap_ext
