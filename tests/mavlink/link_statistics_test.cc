#include "colmap_ext/mavlink/link_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace colmap_ext {
namespace {

MavFrame Numbered(std::uint64_t number, std::uint8_t component = 1) {
  return MakeMavFrame(MavHeartbeat{}, {1, component, static_cast<std::uint8_t>(number)});
}

TEST(MavLinkStatistics, AQuietLinkLosesNothingAcrossTheWrap) {
  MavLinkStatistics link;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(link.Received(Numbered(static_cast<std::uint64_t>(i)), 0.01 * i),
              MavArrival::kInOrder);
  }
  const MavPeerStatistics total = link.Total();
  EXPECT_EQ(total.received, 1000U);
  EXPECT_EQ(total.lost + total.duplicates + total.late + total.outages, 0U);
  EXPECT_NEAR(total.last_heard_s, 9.99, 1e-9);
}

TEST(MavLinkStatistics, LossIsCountedAsItWas) {
  std::mt19937_64 random(5);
  MavLinkStatistics link;
  std::uint64_t dropped = 0;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    if (i > 0 && i < 4999 && random() % 5 == 0) {
      ++dropped;
    } else {
      link.Received(Numbered(i), 0.01 * static_cast<double>(i));
    }
  }
  EXPECT_EQ(link.Total().lost, dropped);
  EXPECT_NEAR(link.Total().LossRatio(), 0.2, 0.02);
}

TEST(MavLinkStatistics, WhatComesLateIsNotLost) {
  MavLinkStatistics link;
  for (const std::uint64_t number : {0U, 1U, 4U, 3U, 5U}) link.Received(Numbered(number), 0);
  EXPECT_EQ(link.Total().lost, 1U);
  EXPECT_EQ(link.Received(Numbered(2), 0), MavArrival::kLate);
  const MavPeerStatistics total = link.Total();
  EXPECT_EQ(total.lost, 0U);
  EXPECT_EQ(total.late, 2U);
  EXPECT_EQ(total.received, 6U);
}

TEST(MavLinkStatistics, WhatComesTwiceIsADuplicate) {
  MavLinkStatistics link;
  for (std::uint64_t i = 250; i < 270; ++i) {
    EXPECT_EQ(link.Received(Numbered(i), 0), MavArrival::kInOrder);
    EXPECT_EQ(link.Received(Numbered(i), 0), MavArrival::kDuplicate);
    if (i > 255) {
      EXPECT_EQ(link.Received(Numbered(i - 5), 0), MavArrival::kDuplicate);
    }
  }
  EXPECT_EQ(link.Total().received, 20U);
  EXPECT_EQ(link.Total().lost, 0U);
}

TEST(MavLinkStatistics, NumbersBeforeTheFirstPacketAreNotLost) {
  MavLinkStatistics link;
  link.Received(Numbered(10), 0);
  EXPECT_EQ(link.Received(Numbered(9), 0), MavArrival::kDuplicate);
  EXPECT_EQ(link.Total().lost, 0U);
}

TEST(MavLinkStatistics, ASilenceIsAnOutageNotLoss) {
  MavLinkStatistics link;
  link.Received(Numbered(10), 0);
  link.Received(Numbered(100), kMavOutageS + 0.1);
  link.Received(Numbered(101), kMavOutageS + 0.2);
  EXPECT_EQ(link.Total().lost, 0U);
  EXPECT_EQ(link.Total().outages, 1U);
  EXPECT_EQ(link.Total().received, 3U);
}

TEST(MavLinkStatistics, ComponentsAreCountedApart) {
  MavLinkStatistics link;
  for (std::uint64_t i = 0; i < 10; ++i) {
    link.Received(Numbered(i, 1), 0);
    link.Received(Numbered(2 * i, 100), 0);
  }
  EXPECT_EQ(link.Peers().at({1, 1}).lost, 0U);
  EXPECT_EQ(link.Peers().at({1, 100}).lost, 9U);
}

// Asks and answers with a delay in each direction; the peer's clock is `offset_s` ahead.
void Exchange(MavRoundTrip* trip, double sent_s, double there_s, double back_s, double offset_s) {
  const MavTimesync request = trip->RequestTimesync(sent_s);
  const auto answer =
      AnswerTimesync(request, MakeMavFrame(request, {255, 190, 0}), 1, sent_s + there_s + offset_s);
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->target_system, 255);
  EXPECT_TRUE(trip->Receive(*answer, sent_s + there_s + back_s));
}

TEST(MavRoundTrip, DurationAndClockOffsetByTimesync) {
  MavRoundTrip trip;
  EXPECT_FALSE(trip.LatestS().has_value());
  EXPECT_FALSE(trip.QuantileS(0.5).has_value());
  EXPECT_FALSE(trip.ClockOffsetS().has_value());
  for (int i = 1; i <= 100; ++i) Exchange(&trip, i, 0.001 * i, 0.002 * i, 1234.5);
  EXPECT_NEAR(*trip.LatestS(), 0.3, 1e-9);
  EXPECT_NEAR(*trip.QuantileS(0.5), 0.153, 1e-9);
  EXPECT_NEAR(*trip.QuantileS(0.99), 0.3, 1e-9);
  // Half of the quickest round trip bounds the error.
  EXPECT_NEAR(*trip.ClockOffsetS(), 1234.5, 0.0015);
}

TEST(MavRoundTrip, DurationByPing) {
  MavRoundTrip trip;
  const MavPing request = trip.RequestPing(5);
  EXPECT_EQ(request.time_usec, 5000000U);
  const auto answer = AnswerPing(request, MakeMavFrame(request, {255, 190, 0}));
  ASSERT_TRUE(answer.has_value());
  EXPECT_TRUE(trip.Receive(*answer, 5.25));
  EXPECT_NEAR(*trip.LatestS(), 0.25, 1e-9);
  EXPECT_FALSE(trip.ClockOffsetS().has_value());
}

TEST(MavRoundTrip, AnAnswerCountsOnceAndForeignOnesNever) {
  MavRoundTrip trip;
  const MavTimesync request = trip.RequestTimesync(1);
  MavTimesync answer = request;
  EXPECT_FALSE(trip.Receive(answer, 2)) << "our own request came back";
  answer.tc1 = 77;
  answer.ts1 += 1;
  EXPECT_FALSE(trip.Receive(answer, 2)) << "nobody asked this";
  answer.ts1 -= 1;
  EXPECT_TRUE(trip.Receive(answer, 2));
  EXPECT_FALSE(trip.Receive(answer, 3)) << "came twice";
}

TEST(MavRoundTrip, RequestsThatNobodyAnswersAreGivenUp) {
  MavRoundTrip trip;
  for (std::size_t i = 0; i < MavRoundTrip::kWindow + 10; ++i) trip.RequestTimesync(1.0);
  EXPECT_EQ(trip.Unanswered(), 10U);
}

TEST(MavRoundTrip, OnlyRequestsForUsAreAnswered) {
  MavTimesync message;
  message.ts1 = 5;
  message.target_system = 9;
  const MavFrame frame = MakeMavFrame(message, {255, 190, 0});
  EXPECT_FALSE(AnswerTimesync(message, frame, 1, 1.0).has_value());
  EXPECT_TRUE(AnswerTimesync(message, frame, 9, 1.0).has_value());
  message.tc1 = 1;
  EXPECT_FALSE(AnswerTimesync(message, frame, 9, 1.0).has_value());
}

}  // namespace
}  // namespace colmap_ext
