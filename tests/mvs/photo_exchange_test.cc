// Superpixel stereo by several processes; here each is a thread with an exchange of its own.
#include "colmap_ext/mvs/photo_exchange.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <thread>

#include "colmap_ext/mvs/superpixel_stereo.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "mvs/analytic_scene.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

test::AnalyticSurvey CornerSurvey() {
  test::AnalyticScene scene;
  scene.rectangles.push_back({{-15, -15, 0}, {30, 0, 0}, {0, 30, 0}, {120, 140, 130}, 1, 50});
  scene.rectangles.push_back({{-1.5, -1.5, 0}, {3, 0, 0}, {0, 0, 2.5}, {190, 70, 60}, 7, 50});
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 5; ++i) {
    const double angle = 0.15 * (i - 2);
    poses.push_back(test::LookAt({9 * std::sin(angle), -9 * std::cos(angle), 6}, {0, 0, 0.5}));
  }
  return test::Survey(scene, test::TestCamera(), poses, 300);
}

class SharedStereo : public ::testing::Test {
 protected:
  SharedStereo()
      : survey_(CornerSurvey()),
        folder_(fs::path(::testing::TempDir()) /
                ("colmap_ext_exchange_" + std::to_string(getpid()))) {}
  ~SharedStereo() override { fs::remove_all(folder_); }

  SuperpixelStereoResult RunAs(const JobRank& rank) const {
    PhotoExchange exchange(survey_.photos, {}, {}, folder_, rank);
    SuperpixelStereoResult result =
        ShareSuperpixelStereo(survey_.photos, {}, {}, JobControl(), &exchange);
    exchange.Finish(JobControl());
    return result;
  }

  test::AnalyticSurvey survey_;
  fs::path folder_;
};

TEST_F(SharedStereo, AllOfThreeGetWhatOneGets) {
  std::vector<SuperpixelStereoResult> results(3);
  {
    std::vector<std::jthread> processes;
    for (int r = 0; r < 3; ++r) {
      processes.emplace_back([&, r] {
        results[static_cast<std::size_t>(r)] = RunAs({r, 3, "start"});
      });
    }
  }
  const SuperpixelStereoResult alone = RunSuperpixelStereo(survey_.photos, {}, {}, JobControl());
  for (const SuperpixelStereoResult& shared : results) {
    ASSERT_EQ(shared.views.size(), alone.views.size());
    for (std::size_t i = 0; i < alone.views.size(); ++i) {
      EXPECT_EQ(shared.views[i].inverse_depth, alone.views[i].inverse_depth) << i;
      EXPECT_EQ(shared.views[i].confidence, alone.views[i].confidence) << i;
      EXPECT_EQ(shared.views[i].supported, alone.views[i].supported) << i;
      EXPECT_EQ(shared.views[i].image.triangles, alone.views[i].image.triangles) << i;
    }
  }
  EXPECT_FALSE(fs::exists(folder_)) << "the first one removes what was exchanged";
}

TEST_F(SharedStereo, OneThatIsAloneSaysWhatItWaitsFor) {
  try {
    RunAs({0, 2, "start", 0.1});
    FAIL() << "did not end";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(survey_.photos.photos[1].name), std::string::npos)
        << error.what();
  }
}

TEST_F(SharedStereo, ADamagedFileIsNamed) {
  std::jthread first([&] { EXPECT_THROW(RunAs({0, 2, "start", 2.0}), Error); });
  fs::path step;
  while (step.empty()) {  // the folder of the first step, whose name is the run's
    if (!fs::exists(folder_)) continue;
    for (const auto& entry : fs::directory_iterator(folder_)) step = entry.path() / "0";
  }
  for (std::size_t i = 1; i < survey_.photos.photos.size(); i += 2) {
    WriteFileAtomically(step / (survey_.photos.photos[i].name + ".bin"), "short");
  }
}

}  // namespace
}  // namespace colmap_ext
