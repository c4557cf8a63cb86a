#include "colmap_ext/mavlink/lossy_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes Packet(int number) {
  return {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8), 0, 0, 0, 0};
}

struct Arrival {
  double time_s;
  Bytes packet;
  bool operator==(const Arrival&) const = default;
};

// Sends `count` packets 10 ms apart and collects what arrives, each when it is due.
std::vector<Arrival> Carry(LossyLink* link, int count) {
  std::vector<Arrival> arrivals;
  const auto deliver_until = [&](double end_s) {
    while (link->NextArrivalS() && *link->NextArrivalS() <= end_s) {
      const double now_s = *link->NextArrivalS();
      link->Deliver(now_s, [&](std::span<const std::uint8_t> packet) {
        arrivals.push_back({now_s, {packet.begin(), packet.end()}});
      });
    }
  };
  for (int i = 0; i < count; ++i) {
    deliver_until(0.01 * i);
    link->Send(Packet(i), 0.01 * i);
  }
  deliver_until(1e9);
  return arrivals;
}

TEST(LossyLink, WithoutFaultsEverythingArrivesAtOnceInOrder) {
  LossyLink link({}, 1);
  const auto arrivals = Carry(&link, 100);
  ASSERT_EQ(arrivals.size(), 100U);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(arrivals[static_cast<std::size_t>(i)], (Arrival{0.01 * i, Packet(i)}));
  }
}

TEST(LossyLink, SharesAreWhatWasAskedFor) {
  LossyLinkOptions options;
  options.loss = 0.2;
  options.duplication = 0.1;
  options.corruption = 0.05;
  LossyLink link(options, 7);
  const auto arrivals = Carry(&link, 20000);
  const LossyLinkCounts& counts = link.Counts();
  EXPECT_EQ(counts.sent, 20000U);
  EXPECT_NEAR(static_cast<double>(counts.lost), 4000, 200);
  EXPECT_NEAR(static_cast<double>(counts.duplicated), 1600, 150);
  EXPECT_EQ(arrivals.size(), counts.sent - counts.lost + counts.duplicated);
  EXPECT_NEAR(static_cast<double>(counts.corrupted), 0.05 * static_cast<double>(arrivals.size()),
              120);
}

TEST(LossyLink, DamageTurnsOneToFourBits) {
  LossyLinkOptions options;
  options.corruption = 1;
  LossyLink link(options, 3);
  int damaged = 0;
  for (const Arrival& arrival : Carry(&link, 500)) {
    int bits = 0;
    const Bytes sent = Packet(static_cast<int>(std::lround(arrival.time_s / 0.01)));
    for (std::size_t i = 0; i < sent.size(); ++i) {
      bits += std::popcount(static_cast<unsigned>(sent[i] ^ arrival.packet[i]));
    }
    EXPECT_LE(bits, 4);
    damaged += bits > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 480);  // two turns of the same bit undo each other
}

TEST(LossyLink, DelayAndJitterAreKeptAndReorder) {
  LossyLinkOptions options;
  options.delay_s = 0.1;
  options.jitter_s = 0.05;
  LossyLink link(options, 5);
  int overtaken = 0;
  int newest = -1;
  for (const Arrival& arrival : Carry(&link, 200)) {
    const int number = arrival.packet[0];
    EXPECT_GE(arrival.time_s, 0.01 * number + 0.1 - 1e-12);
    EXPECT_LE(arrival.time_s, 0.01 * number + 0.15 + 1e-12);
    overtaken += number < newest ? 1 : 0;
    newest = std::max(newest, number);
  }
  EXPECT_GT(overtaken, 20);
}

TEST(LossyLink, TheSeedDecidesAndNothingElse) {
  LossyLinkOptions options;
  options.loss = options.duplication = options.corruption = 0.3;
  options.jitter_s = 0.1;
  LossyLink first(options, 11);
  LossyLink second(options, 11);
  LossyLink other(options, 12);
  const auto arrivals = Carry(&first, 300);
  EXPECT_EQ(Carry(&second, 300), arrivals);
  EXPECT_NE(Carry(&other, 300), arrivals);
}

TEST(LossyLink, ACutLinkCarriesNothingUntilItIsMended) {
  LossyLinkOptions cut;
  cut.is_cut = true;
  LossyLink link({}, 1);
  link.Send(Packet(1), 0);
  link.SetOptions(cut);
  link.Send(Packet(2), 0);
  link.SetOptions({});
  link.Send(Packet(3), 0);
  std::vector<Bytes> received;
  link.Deliver(0, [&](std::span<const std::uint8_t> packet) {
    received.emplace_back(packet.begin(), packet.end());
  });
  EXPECT_EQ(received, (std::vector<Bytes>{Packet(1), Packet(3)}));
}

TEST(LossyLink, WhoReceivesMaySend) {
  LossyLink link({}, 1);
  link.Send(Packet(1), 0);
  int received = 0;
  link.Deliver(0, [&](std::span<const std::uint8_t>) {
    if (++received < 5) link.Send(Packet(received), 0);
  });
  EXPECT_EQ(received, 5);
}

TEST(LossyLink, WrongOptionsAreRefused) {
  const auto refused = [](const auto& change) {
    LossyLinkOptions options;
    change(&options);
    EXPECT_THROW(LossyLink(options, 1), UsageError);
  };
  refused([](LossyLinkOptions* options) { options->loss = 1.1; });
  refused([](LossyLinkOptions* options) { options->duplication = -0.1; });
  refused([](LossyLinkOptions* options) { options->corruption = std::nan(""); });
  refused([](LossyLinkOptions* options) { options->delay_s = -1; });
  refused([](LossyLinkOptions* options) { options->jitter_s = 1e9; });
}

}  // namespace
}  // namespace colmap_ext
