// Our packets against an implementation that shares nothing with ours: everything that we send is
// decoded there, and the other way round, signed and not. Needs node and the packages of
// tests/mavlink/peer, which scripts/install_dependencies.sh --tests installs; fails without them.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/endpoint.h"
#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/files.h"
#include "mavlink/message_json.h"
#include "mavlink/random_messages.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

const fs::path kPeer = fs::path(COLMAP_EXT_SOURCE_DIR) / "tests/mavlink/peer/peer.js";
// The only message of ours that node-mavlink does not know.
constexpr std::uint32_t kUnknownToPeer = MavCommandCancel::kId;

MavSigningKey Key() {
  MavSigningKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(200 + i);
  return key;
}

std::string KeyText() {
  std::string text;
  for (const std::uint8_t byte : Key()) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  return text;
}

double UnixS() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

class Peer : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(fs::exists(kPeer.parent_path() / "node_modules/node-mavlink") &&
                !FindProgram("node").empty())
        << "run scripts/install_dependencies.sh --tests";
    folder_ = fs::path(testing::TempDir()) / ("peer_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  bool IsSigned() const { return GetParam(); }

  ChildProcessResult RunPeer(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"node", kPeer.string()});
    if (IsSigned()) arguments.push_back(KeyText());
    ChildProcessOptions options;
    options.arguments = arguments;
    return RunChildProcess(options, {});
  }
  MavSigning Signing() const { return {Key(), {}, {}, nullptr}; }

  fs::path folder_;
};

INSTANTIATE_TEST_SUITE_P(Signed, Peer, testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Signed" : "Unsigned");
});

constexpr int kRounds = 8;

TEST_P(Peer, DecodesEverythingThatWeSend) {
  std::mt19937_64 random(21);
  MavEndpoint endpoint(7, 8);
  if (IsSigned()) endpoint.EnableSigning(Signing());
  std::ofstream packets(folder_ / "packets", std::ios::binary);
  std::vector<json> expected;
  for (int round = 0; round < kRounds; ++round) {
    ForEveryMavMessage([&]<typename Message>() {
      if (Message::kId == kUnknownToPeer) return;
      const Message message = RandomMavMessage<Message>(&random);
      const auto sequence = static_cast<std::uint8_t>(expected.size());
      const Bytes bytes = endpoint.Encode(message, UnixS());
      packets.write(reinterpret_cast<const char*>(bytes.data()),
                    static_cast<std::streamsize>(bytes.size()));
      expected.push_back({{"id", Message::kId},
                          {"system", 7},
                          {"component", 8},
                          {"sequence", sequence},
                          {"version", 2},
                          {"fields", MavFieldsJson(message)},
                          {"signature", IsSigned() ? "right" : "none"},
                          {"link", 0}});
    });
  }
  packets.close();
  const auto result = RunPeer({"decode", folder_ / "packets", folder_ / "lines"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  std::istringstream lines(ReadFile(folder_ / "lines"));
  std::size_t decoded = 0;
  for (std::string line; std::getline(lines, line) && decoded < expected.size(); ++decoded) {
    ASSERT_EQ(json::parse(line), expected[decoded]);
  }
  EXPECT_EQ(decoded, kRounds * (MavMessages::kSize - 1));
}

TEST_P(Peer, WhatItSendsIsDecodedHere) {
  std::mt19937_64 random(22);
  std::ofstream lines(folder_ / "lines");
  std::vector<std::function<void(const MavFrame&)>> checks;
  for (int round = 0; round < kRounds; ++round) {
    ForEveryMavMessage([&]<typename Message>() {
      if (Message::kId == kUnknownToPeer) return;
      // Nothing but zeros, too: this peer cuts off even the first byte.
      const Message message = round == 0 ? Message{} : RandomMavMessage<Message>(&random);
      const auto sequence = static_cast<std::uint8_t>(checks.size());
      lines << json{{"id", Message::kId},
                    {"system", 1},
                    {"component", 100},
                    {"sequence", sequence},
                    {"fields", MavFieldsJson(message)}}
            << '\n';
      checks.push_back([message, sequence](const MavFrame& frame) {
        EXPECT_EQ(frame.sequence, sequence);
        EXPECT_EQ(frame.component_id, 100);
        EXPECT_EQ(UnpackMav<Message>(frame), message) << Message::kName;
      });
    });
  }
  lines.close();
  const auto result = RunPeer({"encode", folder_ / "lines", folder_ / "packets"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const std::string content = ReadFile(folder_ / "packets");
  MavParser parser;
  std::size_t decoded = 0;
  std::size_t rightly_signed = 0;
  parser.Feed(Bytes(content.begin(), content.end()), [&](const MavFrame& frame) {
    ASSERT_LT(decoded, checks.size());
    checks[decoded++](frame);
    // Timestamps of the peer are not in order here: every packet is judged alone.
    MavSigning signing = Signing();
    if (frame.signature && signing.Check(frame, UnixS()) == MavSignatureVerdict::kAccepted) {
      ++rightly_signed;
    }
  });
  EXPECT_EQ(decoded, checks.size());
  EXPECT_EQ(parser.Counts().skipped_bytes, 0U);
  EXPECT_EQ(rightly_signed, IsSigned() ? checks.size() : 0U);
}

// One end of a UDP link that runs for as long as the peer does.
class LiveLink {
 public:
  LiveLink(std::uint8_t system_id, std::uint8_t component_id)
      : endpoint_(system_id, component_id), link_(&io_, ParseMavLinkUrl("udpin://127.0.0.1:0")) {}
  MavEndpoint& Endpoint() { return endpoint_; }
  std::uint16_t Start(std::function<void(const MavFrame&)> receive) {
    link_.Start({[this, receive](std::span<const std::uint8_t> bytes, bool ends_datagram) {
                   endpoint_.Receive(bytes, ends_datagram, UnixS(), UnixS(), receive);
                 },
                 nullptr});
    return link_.LocalPort();
  }
  template <typename Message>
  void Send(const Message& message) {
    link_.Send(endpoint_.Encode(message, UnixS()));
  }
  // Calls `each` every 20 ms until the peer has ended.
  void RunUntilEnd(std::future<ChildProcessResult> peer, const std::function<void()>& each) {
    while (peer.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      io_.restart();
      io_.run_for(std::chrono::milliseconds(20));
      each();
    }
    const ChildProcessResult result = peer.get();
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }

 private:
  boost::asio::io_context io_;
  MavEndpoint endpoint_;
  MavLink link_;
};

TEST_P(Peer, AsAutopilotItArmsAndLandsForUs) {
  LiveLink link(255, 190);
  if (IsSigned()) link.Endpoint().EnableSigning(Signing());
  MavDispatcher dispatcher;
  MavRoundTrip trip;
  bool is_armed = false;
  float parameter = 0;
  int armed_acks = 0;
  dispatcher.On<MavHeartbeat>([&](const MavHeartbeat& heartbeat, const MavFrame&) {
    EXPECT_EQ(heartbeat.autopilot, MavAutopilot::kArduPilot);
    EXPECT_EQ(heartbeat.custom_mode, static_cast<std::uint32_t>(ArduCopterMode::kGuided));
    is_armed = (heartbeat.base_mode & MavModeFlag::kSafetyArmed) != 0;
  });
  dispatcher.On<MavCommandAck>([&](const MavCommandAck& ack, const MavFrame&) {
    EXPECT_EQ(ack.result, MavResult::kAccepted);
    EXPECT_EQ(ack.target_component, 190);
    if (ack.command == MavCmd::kComponentArmDisarm) ++armed_acks;
  });
  dispatcher.On<MavTimesync>(
      [&](const MavTimesync& answer, const MavFrame&) { trip.Receive(answer, UnixS()); });
  dispatcher.On<MavParamValue>([&](const MavParamValue& value, const MavFrame&) {
    EXPECT_EQ(MavText(value.param_id), "FENCE_ENABLE");
    parameter = value.param_value;
  });
  const std::uint16_t port = link.Start([&](const MavFrame& frame) { dispatcher.Dispatch(frame); });
  auto peer = std::async(std::launch::async, [&] {
    return RunPeer({"autopilot", std::to_string(port)});
  });
  link.RunUntilEnd(std::move(peer), [&] {
    MavCommandLong command;
    command.target_system = 1;
    command.target_component = 1;
    command.param1 = 1;
    const bool is_ready = is_armed && parameter == 1.5F && trip.LatestS();
    command.command = is_ready ? MavCmd::kNavLand : MavCmd::kComponentArmDisarm;
    link.Send(command);
    link.Send(trip.RequestTimesync(UnixS()));
    MavParamRequestRead read;
    SetMavText("FENCE_ENABLE", &read.param_id);
    read.param_index = -1;
    link.Send(read);
  });
  EXPECT_GT(armed_acks, 0);
  EXPECT_LT(trip.QuantileS(0.5).value_or(1), 0.2);
  EXPECT_NEAR(trip.ClockOffsetS().value_or(0) + UnixS(), 123, 20);
}

TEST_P(Peer, AsGroundStationItArmsUs) {
  LiveLink link(1, 1);
  if (IsSigned()) link.Endpoint().EnableSigning(Signing());
  MavDispatcher dispatcher;
  MavHeartbeat own;
  own.type = MavType::kQuadrotor;
  own.mavlink_version = 3;
  bool is_ground_heard = false;
  dispatcher.On<MavHeartbeat>([&](const MavHeartbeat& heartbeat, const MavFrame&) {
    is_ground_heard = heartbeat.type == MavType::kGcs;
  });
  dispatcher.On<MavCommandLong>([&](const MavCommandLong& command, const MavFrame& frame) {
    EXPECT_EQ(command.command, MavCmd::kComponentArmDisarm);
    EXPECT_EQ(command.param1, 1);
    own.base_mode = MavModeFlag::kSafetyArmed;
    MavCommandAck ack;
    ack.command = command.command;
    ack.target_system = frame.system_id;
    ack.target_component = frame.component_id;
    link.Send(ack);
  });
  const std::uint16_t port = link.Start([&](const MavFrame& frame) { dispatcher.Dispatch(frame); });
  auto peer = std::async(std::launch::async, [&] {
    return RunPeer({"ground", std::to_string(port)});
  });
  link.RunUntilEnd(std::move(peer), [&] { link.Send(own); });
  EXPECT_TRUE(is_ground_heard);
}

}  // namespace
}  // namespace colmap_ext
