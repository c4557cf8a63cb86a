#include "safety_campaign.h"

#include <gtest/gtest.h>

namespace colmap_ext {
namespace {

// The whole campaign of 1,000 sites is bench_path.
TEST(SafetyCampaign, NoAcceptedPathBreaksItsPromisesInRandomSites) {
  const SafetyFindings findings = RunSafetyCampaign(20000, 60);
  EXPECT_EQ(findings.Complaint(), "");
  EXPECT_EQ(findings.sites, 60);
  EXPECT_GE(findings.least_spare_m, 0);
  // It is about something: paths were flown, views dropped, starts refused.
  EXPECT_GT(findings.flown_views, 60);
  EXPECT_GT(findings.dropped_views, 20);
  EXPECT_GT(findings.refused_starts, 0);
}

// The sampler finds what is wrong: a planner that is told a smaller distance breaks the larger one.
TEST(SafetyCampaign, SeesAPathThatIsTooNear) {
  SafetyFindings findings;
  findings.too_near = 1;
  EXPECT_NE(findings.Complaint(), "");
  const RandomSite site = MakeRandomSite(3);
  EXPECT_LT(DistanceToPatches(site.observed, {0, 0, 0.5}, 10), 1);
  EXPECT_EQ(DistanceToPatches(site.observed, {0, 0, 60}, 10), 10);
}

TEST(RandomSite, LinesOfSightAreBlockedByWhatIsThere) {
  RandomSite site = MakeRandomSite(4);
  site.observed = {{{Eigen::Vector3d(-5, 0, -5), Eigen::Vector3d(5, 0, 5)}, true}};
  PosedPhoto photo = site.photos[0];
  photo.cam_from_world = CamFromWorld({0, -10, 0}, {0, 0});
  EXPECT_EQ(SightOf(photo, site.observed, {0, -5, 0}), Sight::kThrough);
  EXPECT_EQ(SightOf(photo, site.observed, {0, 5, 0}), Sight::kBlocked);
  EXPECT_EQ(SightOf(photo, site.observed, {0, -20, 0}), Sight::kNone);
  site.observed[0].box.translate(Eigen::Vector3d(0, 0, 30));
  EXPECT_EQ(SightOf(photo, site.observed, {0, -5, 0}), Sight::kOpen);
}

}  // namespace
}  // namespace colmap_ext
