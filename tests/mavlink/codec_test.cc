#include "colmap_ext/mavlink/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "mavlink/random_messages.h"

namespace colmap_ext {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<MavFrame> ParseAll(MavParser* parser, const Bytes& bytes) {
  std::vector<MavFrame> frames;
  parser->Feed(bytes, [&](const MavFrame& frame) { frames.push_back(frame); });
  return frames;
}

Bytes Join(const std::vector<Bytes>& parts) {
  Bytes joined;
  for (const Bytes& part : parts) joined.insert(joined.end(), part.begin(), part.end());
  return joined;
}

MavHeartbeat Copter() {
  MavHeartbeat heartbeat;
  heartbeat.type = MavType::kQuadrotor;
  heartbeat.autopilot = MavAutopilot::kArduPilot;
  heartbeat.base_mode = MavModeFlag::kCustomModeEnabled;
  heartbeat.custom_mode = static_cast<std::uint32_t>(ArduCopterMode::kGuided);
  heartbeat.system_status = MavState::kActive;
  heartbeat.mavlink_version = 3;
  return heartbeat;
}

// The same message in MAVLink 1, as a very old component sends it.
Bytes PackV1(const MavHeartbeat& heartbeat) {
  MavFrame frame = MakeMavFrame(heartbeat, {1, 1, 7});
  frame.version = 1;
  frame.payload_length = 9;
  frame.checksum = MavChecksumOf(frame, 50);
  return MavFrameBytes(frame);
}

TEST(MavCodec, EveryMessageComesBackAsItWas) {
  std::mt19937_64 random(1);
  MavParser parser;
  std::size_t messages = 0;
  ForEveryMavMessage([&]<typename Message>() {
    for (int i = 0; i < 50; ++i) {
      const Message sent = RandomMavMessage<Message>(&random);
      const auto frames = ParseAll(&parser, PackMav(sent, {42, 7, static_cast<std::uint8_t>(i)}));
      ASSERT_EQ(frames.size(), 1U) << Message::kName;
      EXPECT_EQ(frames[0].system_id, 42);
      EXPECT_EQ(frames[0].component_id, 7);
      EXPECT_EQ(frames[0].sequence, i);
      EXPECT_EQ(UnpackMav<Message>(frames[0]), sent) << Message::kName;
    }
    ++messages;
  });
  EXPECT_EQ(messages, MavMessages::kSize);
  EXPECT_EQ(parser.Counts().skipped_bytes, 0U);
}

TEST(MavCodec, BytesOfAHeartbeat) {
  const Bytes bytes = PackMav(Copter(), {1, 1, 5});
  const Bytes expected_without_checksum = {0xFD, 9, 0, 0, 5, 1, 1, 0, 0, 0,
                                           4,    0, 0, 0, 2, 3, 1, 4, 3};
  ASSERT_EQ(bytes.size(), expected_without_checksum.size() + 2);
  EXPECT_TRUE(std::equal(expected_without_checksum.begin(), expected_without_checksum.end(),
                         bytes.begin()));
}

TEST(MavCodec, TrailingZerosAreCutOffButOneByteStays) {
  MavCommandAck ack;
  ack.command = MavCmd::kNavTakeoff;
  EXPECT_EQ(MakeMavFrame(ack, {}).payload_length, 1);
  ack.target_component = 190;
  EXPECT_EQ(MakeMavFrame(ack, {}).payload_length, 10);
  EXPECT_EQ(MakeMavFrame(MavHeartbeat{}, {}).payload_length, 1);
}

TEST(MavCodec, NanSurvives) {
  MavGimbalManagerSetPitchyaw aim;
  aim.yaw = std::numeric_limits<float>::quiet_NaN();
  const auto back = UnpackMav<MavGimbalManagerSetPitchyaw>(MakeMavFrame(aim, {}));
  ASSERT_TRUE(back.has_value());
  EXPECT_TRUE(std::isnan(back->yaw));
  EXPECT_EQ(back->pitch, 0);
}

TEST(MavCodec, AnotherMessageIsNotUnpacked) {
  EXPECT_FALSE(UnpackMav<MavAttitude>(MakeMavFrame(Copter(), {})).has_value());
}

TEST(MavCodec, AMessageThatGrewKeepsTheFieldsThatWeKnow) {
  MavFrame frame = MakeMavFrame(Copter(), {1, 1, 0});
  frame.payload[9] = 77;
  frame.payload_length = 10;
  frame.checksum = MavChecksumOf(frame, 50);
  MavParser parser;
  const auto frames = ParseAll(&parser, MavFrameBytes(frame));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(UnpackMav<MavHeartbeat>(frames[0]), Copter());
}

TEST(MavParser, VersionOneIsUnderstood) {
  MavParser parser;
  const auto frames = ParseAll(&parser, PackV1(Copter()));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].version, 1);
  EXPECT_EQ(frames[0].sequence, 7);
  EXPECT_EQ(UnpackMav<MavHeartbeat>(frames[0]), Copter());
}

TEST(MavParser, AVersionOnePayloadThatIsTooShortIsRefused) {
  MavFrame frame = MakeMavFrame(Copter(), {1, 1, 7});
  frame.version = 1;
  frame.payload_length = 8;
  frame.checksum = MavChecksumOf(frame, 50);
  MavParser parser;
  EXPECT_TRUE(ParseAll(&parser, MavFrameBytes(frame)).empty());
  EXPECT_EQ(parser.Counts().bad_checksums, 1U);
}

TEST(MavParser, AnySplitOfTheStreamGivesTheSameFrames) {
  std::mt19937_64 random(2);
  std::vector<Bytes> packets;
  for (int i = 0; i < 30; ++i) {
    packets.push_back(PackMav(RandomMavMessage<MavGpsRawInt>(&random), {1, 1, 0}));
    packets.push_back(PackMav(RandomMavMessage<MavStatustext>(&random), {1, 1, 1}));
    packets.push_back(PackV1(Copter()));
  }
  const Bytes stream = Join(packets);
  MavParser whole;
  const auto expected = ParseAll(&whole, stream);
  ASSERT_EQ(expected.size(), packets.size());
  for (const std::size_t longest : {1U, 2U, 7U, 50U, 400U}) {
    MavParser parser;
    std::vector<MavFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t count = std::min<std::size_t>(1 + random() % longest, stream.size() - at);
      parser.Feed(std::span(stream).subspan(at, count),
                  [&](const MavFrame& frame) { frames.push_back(frame); });
      at += count;
    }
    EXPECT_EQ(frames, expected);
    EXPECT_EQ(parser.Counts().skipped_bytes, 0U);
  }
}

TEST(MavParser, GarbageBetweenPacketsCostsNoPacket) {
  std::mt19937_64 random(3);
  MavParser parser;
  std::vector<MavFrame> sent;
  Bytes stream;
  for (int i = 0; i < 300; ++i) {
    // Garbage with start bytes in it, but with flags that make them false.
    for (std::size_t n = random() % 40; n > 0; --n) {
      const auto byte = static_cast<std::uint8_t>(random());
      stream.push_back(byte == kMavMagicV1 ? 0 : byte);
    }
    stream.insert(stream.end(), 3, 0xFD);
    stream.insert(stream.end(), 12, 0xFF);
    sent.push_back(MakeMavFrame(RandomMavMessage<MavAttitude>(&random), {1, 1, 9}));
    const Bytes packet = MavFrameBytes(sent.back());
    stream.insert(stream.end(), packet.begin(), packet.end());
  }
  EXPECT_EQ(ParseAll(&parser, stream), sent);
  EXPECT_GT(parser.Counts().skipped_bytes, 300U * 15U);
}

TEST(MavParser, ADamagedPacketCostsOnlyItself) {
  std::mt19937_64 random(4);
  const Bytes good = PackMav(Copter(), {1, 1, 1});
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = good;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ 1U << bit);
      std::vector<Bytes> parts = {good, damaged};
      for (int n = 0; n < 20; ++n) parts.push_back(good);
      MavParser parser;
      EXPECT_EQ(ParseAll(&parser, Join(parts)).size(), 21U) << "byte " << i << " bit " << bit;
    }
  }
}

TEST(MavParser, UnknownMessagesAreSkippedWhole) {
  MavFrame unknown = MakeMavFrame(Copter(), {1, 1, 1});
  unknown.message_id = 36;  // SERVO_OUTPUT_RAW, which we do not speak
  unknown.payload[3] = kMavMagicV2;
  MavParser parser;
  const Bytes good = PackMav(Copter(), {1, 1, 2});
  EXPECT_EQ(ParseAll(&parser, Join({good, MavFrameBytes(unknown), good})).size(), 2U);
  EXPECT_EQ(parser.Counts().unknown_messages, 1U);
  EXPECT_EQ(parser.Counts().skipped_bytes, 0U);
}

TEST(MavParser, PacketsWithFlagsThatWeDoNotKnowAreDropped) {
  MavFrame frame = MakeMavFrame(Copter(), {1, 1, 1});
  frame.incompat_flags = 2;
  frame.checksum = MavChecksumOf(frame, 50);
  MavParser parser;
  EXPECT_TRUE(ParseAll(&parser, MavFrameBytes(frame)).empty());
  EXPECT_EQ(parser.Counts().unsupported_flags, 1U);
}

TEST(MavParser, AHalfPacketDoesNotWaitBeyondItsDatagram) {
  const Bytes good = PackMav(Copter(), {1, 1, 1});
  const Bytes half(good.begin(), good.begin() + 12);
  std::size_t received = 0;
  const auto count = [&](const MavFrame&) { ++received; };
  MavParser parser;
  parser.Feed(half, count);
  parser.EndOfDatagram(count);
  EXPECT_EQ(received, 0U);
  EXPECT_EQ(parser.Counts().skipped_bytes, half.size());
  // A false start byte whose length reaches over the end hides the whole packet behind it.
  parser.Feed(Join({{0xFD, 200, 0, 0, 0, 1, 1, 0, 0, 0}, good}), count);
  EXPECT_EQ(received, 0U);
  parser.EndOfDatagram(count);
  EXPECT_EQ(received, 1U);
}

TEST(MavDispatcher, CallsWhoeverAskedForTheMessage) {
  MavDispatcher dispatcher;
  int heartbeats = 0;
  int attitudes = 0;
  dispatcher.On<MavHeartbeat>([&](const MavHeartbeat& heartbeat, const MavFrame& frame) {
    EXPECT_EQ(heartbeat, Copter());
    EXPECT_EQ(frame.system_id, 3);
    ++heartbeats;
  });
  dispatcher.On<MavHeartbeat>([&](const MavHeartbeat&, const MavFrame&) { ++heartbeats; });
  dispatcher.On<MavAttitude>([&](const MavAttitude&, const MavFrame&) { ++attitudes; });
  EXPECT_TRUE(dispatcher.Dispatch(MakeMavFrame(Copter(), {3, 1, 0})));
  EXPECT_FALSE(dispatcher.Dispatch(MakeMavFrame(MavPing{}, {3, 1, 0})));
  EXPECT_EQ(heartbeats, 2);
  EXPECT_EQ(attitudes, 0);
}

TEST(MavSender, NumbersItsPacketsAndWrapsAround) {
  MavSender sender(255, 190);
  for (int i = 0; i < 600; ++i) {
    const MavFrame frame = sender.Next(MavHeartbeat{});
    EXPECT_EQ(frame.sequence, i % 256);
    EXPECT_EQ(frame.system_id, 255);
    EXPECT_EQ(frame.component_id, 190);
  }
}

}  // namespace
}  // namespace colmap_ext
