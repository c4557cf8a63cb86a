#include "colmap_ext/mavlink/signing.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/util/error.h"
#include "mavlink/random_messages.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kNowS = 1.8e9;

MavSigningKey KeyOf(std::uint8_t seed) {
  MavSigningKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(seed + i);
  return key;
}

MavSigning Signer(std::uint8_t seed = 1, MavSigningOptions options = {},
                  const MavSigningState& state = {}) {
  return {KeyOf(seed), std::move(options), state, nullptr};
}

MavFrame Heartbeat(std::uint8_t component = 1) {
  MavHeartbeat heartbeat;
  heartbeat.custom_mode = 4;
  return MakeMavFrame(heartbeat, {1, component, 0});
}

class SigningFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("signing_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path Write(const std::string& name, const std::string& content) const {
    const fs::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << content;
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
    return path;
  }
  fs::path folder_;
};

TEST(MavTimestamp, CountsTensOfMicrosecondsSince2015) {
  EXPECT_EQ(MavTimestamp(1420070400.0), 0U);
  EXPECT_EQ(MavTimestamp(1420070401.5), 150000U);
  EXPECT_EQ(MavTimestamp(0), 0U);
  EXPECT_EQ(MavTimestamp(1e300), (std::uint64_t{1} << 48U) - 1);
}

TEST(MavSigning, EverySignedMessageIsAcceptedAfterTheParser) {
  MavSigning ours = Signer();
  MavSigning theirs = Signer();
  MavParser parser;
  std::mt19937_64 random(1);
  std::size_t accepted = 0;
  ForEveryMavMessage([&]<typename Message>() {
    MavFrame frame = MakeMavFrame(RandomMavMessage<Message>(&random), {1, 1, 0});
    ours.Sign(&frame, kNowS);
    parser.Feed(MavFrameBytes(frame), [&](const MavFrame& received) {
      EXPECT_EQ(received, frame);
      EXPECT_EQ(theirs.Check(received, kNowS), MavSignatureVerdict::kAccepted);
      ++accepted;
    });
  });
  EXPECT_EQ(accepted, MavMessages::kSize);
  EXPECT_EQ(theirs.Counts().accepted, accepted);
}

TEST(MavSigning, AnotherKeyIsRefused) {
  MavSigning stranger = Signer(2);
  MavSigning theirs = Signer(1);
  MavFrame frame = Heartbeat();
  stranger.Sign(&frame, kNowS);
  EXPECT_EQ(theirs.Check(frame, kNowS), MavSignatureVerdict::kWrong);
}

TEST(MavSigning, EveryChangedBitIsNoticed) {
  MavSigning ours = Signer();
  MavFrame frame = Heartbeat();
  ours.Sign(&frame, kNowS);
  const std::vector<std::uint8_t> good = MavFrameBytes(frame);
  for (std::size_t i = 10; i < good.size(); ++i) {
    std::vector<std::uint8_t> bytes = good;
    bytes[i] ^= 4;
    MavParser parser;
    MavSigning theirs = Signer();
    parser.Feed(bytes, [&](const MavFrame& received) {
      EXPECT_EQ(theirs.Check(received, kNowS), MavSignatureVerdict::kWrong) << i;
    });
  }
}

TEST(MavSigning, AReplayedPacketIsRefused) {
  MavSigning ours = Signer();
  MavSigning theirs = Signer();
  MavFrame first = Heartbeat();
  MavFrame second = Heartbeat();
  ours.Sign(&first, kNowS);
  ours.Sign(&second, kNowS);
  EXPECT_GT(second.signature->timestamp, first.signature->timestamp);
  EXPECT_EQ(theirs.Check(second, kNowS), MavSignatureVerdict::kAccepted);
  EXPECT_EQ(theirs.Check(second, kNowS), MavSignatureVerdict::kReplayed);
  EXPECT_EQ(theirs.Check(first, kNowS), MavSignatureVerdict::kReplayed);
}

TEST(MavSigning, StreamsAreSystemComponentAndLink) {
  MavSigningOptions other_link;
  other_link.link_id = 3;
  MavSigning first_link = Signer();
  MavSigning second_link = Signer(1, other_link);
  MavSigning theirs = Signer();
  MavFrame newer = Heartbeat();
  first_link.Sign(&newer, kNowS + 10);
  EXPECT_EQ(theirs.Check(newer, kNowS), MavSignatureVerdict::kAccepted);
  MavFrame same_stream = Heartbeat();
  MavFrame other_component = Heartbeat(100);
  MavFrame link_three = Heartbeat();
  MavSigning late = Signer();
  late.Sign(&same_stream, kNowS);
  late.Sign(&other_component, kNowS);
  second_link.Sign(&link_three, kNowS);
  EXPECT_EQ(theirs.Check(same_stream, kNowS), MavSignatureVerdict::kReplayed);
  EXPECT_EQ(theirs.Check(other_component, kNowS), MavSignatureVerdict::kAccepted);
  EXPECT_EQ(theirs.Check(link_three, kNowS), MavSignatureVerdict::kAccepted);
}

TEST(MavSigning, ANewStreamMayBeAMinuteBehindNotMore) {
  for (const auto& [behind_s, verdict] : {std::pair(59.0, MavSignatureVerdict::kAccepted),
                                          std::pair(61.0, MavSignatureVerdict::kTooOld)}) {
    MavSigning ours = Signer();
    MavSigning theirs = Signer();
    MavFrame frame = Heartbeat();
    ours.Sign(&frame, kNowS - behind_s);
    EXPECT_EQ(theirs.Check(frame, kNowS), verdict) << behind_s;
  }
}

TEST(MavSigning, APeerWhoseClockIsAheadPullsOursAlong) {
  MavSigning ahead = Signer();
  MavSigning ours = Signer();
  MavFrame from_ahead = Heartbeat();
  ahead.Sign(&from_ahead, kNowS + 1e5);
  EXPECT_EQ(ours.Check(from_ahead, kNowS), MavSignatureVerdict::kAccepted);
  MavFrame answer = Heartbeat(190);
  ours.Sign(&answer, kNowS);
  EXPECT_GT(answer.signature->timestamp, from_ahead.signature->timestamp);
  EXPECT_EQ(ahead.Check(answer, kNowS + 1e5), MavSignatureVerdict::kAccepted);
}

TEST(MavSigning, UnsignedPacketsAreRefusedButForTheRadio) {
  MavSigning ours = Signer();
  EXPECT_EQ(ours.Check(Heartbeat(), kNowS), MavSignatureVerdict::kUnsigned);
  EXPECT_EQ(ours.Check(MakeMavFrame(MavRadioStatus{}, {51, 68, 0}), kNowS),
            MavSignatureVerdict::kAccepted);
}

TEST(MavSigning, TimestampsNeverGoBackThroughACrash) {
  MavSigningState saved;
  std::uint64_t last = 0;
  std::size_t saves = 0;
  for (int run = 0; run < 5; ++run) {
    // The clock stands still, or jumps back: the machine has no battery for it.
    const double start_s = kNowS - run;
    MavSigning signing(KeyOf(1), {}, saved, [&](const MavSigningState& state) {
      saved = state;
      ++saves;
    });
    for (int i = 0; i < 500; ++i) {
      MavFrame frame = Heartbeat();
      signing.Sign(&frame, start_s + 0.1 * i);
      EXPECT_GT(frame.signature->timestamp, last);
      EXPECT_LE(frame.signature->timestamp, saved.timestamp);
      last = frame.signature->timestamp;
    }
  }
  EXPECT_LT(saves, 40U) << "one save for about ten seconds";
}

TEST(MavSigning, ReplaysAreRefusedAfterARestart) {
  MavSigning vehicle = Signer();
  MavFrame frame = Heartbeat();
  vehicle.Sign(&frame, kNowS);
  MavSigning first = Signer();
  ASSERT_EQ(first.Check(frame, kNowS), MavSignatureVerdict::kAccepted);
  MavSigning second = Signer(1, {}, first.State());
  EXPECT_EQ(second.Check(frame, kNowS), MavSignatureVerdict::kReplayed);
}

TEST_F(SigningFiles, StateComesBackFromItsFile) {
  MavSigningState state;
  state.timestamp = 123456789012345;
  state.streams[{1, 1, 0}] = 77;
  state.streams[{1, 100, 3}] = 123456789012344;
  WriteMavSigningState(folder_ / "state.json", state);
  EXPECT_EQ(ReadMavSigningState(folder_ / "state.json"), state);
  EXPECT_EQ(ReadMavSigningState(folder_ / "none.json"), MavSigningState{});
}

TEST_F(SigningFiles, DamagedStateIsAnErrorNotAnEmptyState) {
  for (const char* content : {"", "{", "{}", R"({"timestamp": "x", "streams": []})",
                              R"({"timestamp": 1, "streams": [{"system": 1}]})"}) {
    EXPECT_THROW(ReadMavSigningState(Write("state.json", content)), Error) << content;
  }
}

TEST_F(SigningFiles, KeysAreReadAsBytesOrHexDigits) {
  std::string raw;
  std::string hex;
  for (std::size_t i = 0; i < 32; ++i) {
    raw += static_cast<char>(1 + i);
    const char* const digits = "0123456789aBcDeF";
    hex += digits[(1 + i) >> 4U];
    hex += digits[(1 + i) & 15U];
  }
  EXPECT_EQ(ReadMavSigningKey(Write("raw", raw)), KeyOf(1));
  EXPECT_EQ(ReadMavSigningKey(Write("hex", hex)), KeyOf(1));
  EXPECT_EQ(ReadMavSigningKey(Write("line", " " + hex + "\r\n")), KeyOf(1));
}

TEST_F(SigningFiles, WrongKeyFilesAreRefused) {
  EXPECT_THROW(ReadMavSigningKey(folder_ / "none"), Error);
  EXPECT_THROW(ReadMavSigningKey(Write("empty", "")), Error);
  EXPECT_THROW(ReadMavSigningKey(Write("short", std::string(31, 'x'))), Error);
  EXPECT_THROW(ReadMavSigningKey(Write("nohex", std::string(64, 'g'))), Error);
  const fs::path open = Write("open", std::string(32, 'x'));
  EXPECT_NO_THROW(ReadMavSigningKey(open));
  fs::permissions(open, fs::perms::group_read, fs::perm_options::add);
  EXPECT_THROW(ReadMavSigningKey(open), Error);
}

TEST(MavSigning, SetupCarriesKeyAndTime) {
  const MavSetupSigning setup = MakeSetupSigning(KeyOf(9), kNowS, 1, 1);
  EXPECT_EQ(setup.secret_key, KeyOf(9));
  EXPECT_EQ(setup.initial_timestamp, MavTimestamp(kNowS));
  EXPECT_EQ(setup.target_system, 1);
}

}  // namespace
}  // namespace colmap_ext
