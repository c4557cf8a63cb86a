#include "colmap_ext/mavlink/endpoint.h"

#include <gtest/gtest.h>

#include <vector>

#include "colmap_ext/mavlink/lossy_link.h"

namespace colmap_ext {
namespace {

constexpr double kUnixS = 1.8e9;

MavSigning Signing(std::uint8_t seed) {
  MavSigningKey key;
  key.fill(seed);
  return {key, {}, {}, nullptr};
}

std::vector<MavFrame> Hear(MavEndpoint* endpoint, const std::vector<std::uint8_t>& bytes) {
  std::vector<MavFrame> frames;
  endpoint->Receive(bytes, true, 0, kUnixS,
                    [&](const MavFrame& frame) { frames.push_back(frame); });
  return frames;
}

TEST(MavEndpoint, WhatOneSaysTheOtherHears) {
  MavEndpoint ground(255, 190);
  MavEndpoint vehicle(1, 1);
  for (int i = 0; i < 10; ++i) {
    const auto frames = Hear(&ground, vehicle.Encode(MavHeartbeat{}, kUnixS));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].sequence, i);
  }
  EXPECT_EQ(ground.Statistics().Total().received, 10U);
  EXPECT_EQ(ground.Statistics().Total().lost, 0U);
}

TEST(MavEndpoint, ItsOwnPacketsAreNotForIt) {
  MavEndpoint ground(255, 190);
  EXPECT_TRUE(Hear(&ground, ground.Encode(MavHeartbeat{}, kUnixS)).empty());
}

TEST(MavEndpoint, WithSigningOnlyTheRightKeyIsHeard) {
  MavEndpoint ground(255, 190);
  MavEndpoint friendly(1, 1);
  MavEndpoint stranger(2, 1);
  MavEndpoint unsigned_one(3, 1);
  ground.EnableSigning(Signing(1));
  friendly.EnableSigning(Signing(1));
  stranger.EnableSigning(Signing(2));
  EXPECT_EQ(Hear(&ground, friendly.Encode(MavHeartbeat{}, kUnixS)).size(), 1U);
  EXPECT_TRUE(Hear(&ground, stranger.Encode(MavHeartbeat{}, kUnixS)).empty());
  EXPECT_TRUE(Hear(&ground, unsigned_one.Encode(MavHeartbeat{}, kUnixS)).empty());
  EXPECT_EQ(ground.Signing()->Counts().wrong, 1U);
  EXPECT_EQ(ground.Signing()->Counts().without_signature, 1U);
  EXPECT_EQ(Hear(&unsigned_one, friendly.Encode(MavHeartbeat{}, kUnixS)).size(), 1U)
      << "who has no key hears signed packets too";
}

TEST(MavEndpoint, LossIsMeasuredAndReplaysAreStoppedByTheSignature) {
  LossyLinkOptions options;
  options.loss = 0.2;
  options.duplication = 0.2;
  LossyLink air(options, 4);
  MavEndpoint ground(255, 190);
  MavEndpoint vehicle(1, 1);
  ground.EnableSigning(Signing(1));
  vehicle.EnableSigning(Signing(1));
  std::size_t heard = 0;
  for (int i = 0; i < 2000; ++i) {
    const double now_s = 0.01 * i;
    air.Send(vehicle.Encode(MavAttitude{}, kUnixS + now_s), now_s);
    air.Deliver(now_s, [&](std::span<const std::uint8_t> packet) {
      ground.Receive(packet, true, now_s, kUnixS + now_s, [&](const MavFrame&) { ++heard; });
    });
  }
  const LossyLinkCounts& counts = air.Counts();
  EXPECT_EQ(heard, counts.sent - counts.lost);
  EXPECT_EQ(ground.Signing()->Counts().replayed, counts.duplicated);
  EXPECT_NEAR(ground.Statistics().Total().LossRatio(), 0.2, 0.03);
}

}  // namespace
}  // namespace colmap_ext
