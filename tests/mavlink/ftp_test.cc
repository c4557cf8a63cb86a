#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/mavlink/ftp_client.h"
#include "colmap_ext/mavlink/ftp_payload.h"
#include "colmap_ext/mavlink/ftp_server.h"
#include "colmap_ext/mavlink/lossy_link.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

TEST(MavFtpPayload, ComesBackFromTheMessage) {
  MavFtpPayload payload;
  payload.sequence = 0xABCD;
  payload.session = 3;
  payload.opcode = MavFtpOpcode::kAck;
  payload.request_opcode = MavFtpOpcode::kBurstReadFile;
  payload.burst_complete = true;
  payload.offset = 0x12345678;
  payload.data = Bytes(kMavFtpMaxData, 7);
  payload.size = kMavFtpMaxData;
  const MavFileTransferProtocol message = EncodeMavFtp(payload, 1, 100);
  EXPECT_EQ(DecodeMavFtp(message), payload);
  EXPECT_EQ(message.payload[0], 0xCD);
  EXPECT_EQ(message.payload[5], 15);
  EXPECT_EQ(message.payload[11], 0x12);
  EXPECT_EQ(message.target_component, 100);
}

TEST(MavFtpPayload, ASizeBeyondThePayloadIsRefused) {
  MavFileTransferProtocol message = EncodeMavFtp({}, 1, 1);
  message.payload[4] = 240;
  EXPECT_FALSE(DecodeMavFtp(message).has_value());
}

TEST(MavFtpUrl, PathAndComponent) {
  EXPECT_EQ(ParseMavFtpUrl("mftp:///pictures/1.jpg"), (MavFtpUrl{{}, "/pictures/1.jpg"}));
  EXPECT_EQ(ParseMavFtpUrl("mftp://1.jpg"), (MavFtpUrl{{}, "1.jpg"}));
  EXPECT_EQ(ParseMavFtpUrl("mftp://[;comp=100]/1.jpg"), (MavFtpUrl{100, "/1.jpg"}));
  EXPECT_EQ(ParseMavFtpUrl("mftp://[comp=100:]1.jpg"), (MavFtpUrl{100, "1.jpg"}));
  for (const char* text : {"", "mftp://", "http://a/b", "mftp://[;comp=300]/a", "mftp://[comp=]/a",
                           "mftp://[;comp=1", "mftp://[x]/a"}) {
    EXPECT_FALSE(ParseMavFtpUrl(text).has_value()) << text;
  }
}

// A folder with files, a server of it and a client, with a link of each direction between them.
class Ftp : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("ftp_" + std::to_string(std::random_device{}()));
    fs::create_directories(root_ / "served" / "low");
    Write(root_ / "secret.txt", Bytes(10, 's'));
  }
  void TearDown() override { fs::remove_all(root_); }

  static void Write(const fs::path& path, const Bytes& content) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()),
               static_cast<std::streamsize>(content.size()));
  }
  Bytes MakeFile(const std::string& name, std::size_t size) {
    Bytes content(size);
    std::mt19937_64 random(size);
    for (std::uint8_t& byte : content) byte = static_cast<std::uint8_t>(random());
    Write(root_ / "served" / name, content);
    return content;
  }

  void Connect(const LossyLinkOptions& link = {}, const MavFtpServerOptions& server = {},
               const MavFtpClientOptions& client = {}) {
    up_.emplace(link, 1);
    down_.emplace(link, 2);
    server_.emplace(root_ / "served", server);
    client_.emplace(client);
  }

  void Respond(const std::vector<MavFileTransferProtocol>& messages) {
    for (const auto& message : messages) {
      down_->Send(PackMav(message, {1, 100, 0}), now_s_);
      ++answers_;
    }
  }

  // Runs events in order of time until nobody waits for anything; returns the seconds it took.
  double Run(double limit_s = 600, const std::function<void()>& each = nullptr) {
    const double start_s = now_s_;
    while (now_s_ - start_s < limit_s) {
      for (const MavFtpPayload& payload : client_->TakeOutgoing()) {
        up_->Send(PackMav(EncodeMavFtp(payload, 1, 100), {255, 190, 0}), now_s_);
      }
      std::optional<double> next_s;
      for (const auto& time_s : {client_->NextTimeS(), server_->NextTimeS(), up_->NextArrivalS(),
                                 down_->NextArrivalS()}) {
        if (time_s) next_s = std::min(next_s.value_or(*time_s), *time_s);
      }
      if (!next_s) break;
      now_s_ = std::max(now_s_, *next_s);
      up_->Deliver(now_s_, [&](std::span<const std::uint8_t> packet) {
        at_server_.Feed(packet, [&](const MavFrame& frame) {
          Respond(server_->Receive(*UnpackMav<MavFileTransferProtocol>(frame), frame, now_s_));
        });
        at_server_.EndOfDatagram([](const MavFrame&) {});
      });
      Respond(server_->Poll(now_s_));
      down_->Deliver(now_s_, [&](std::span<const std::uint8_t> packet) {
        at_client_.Feed(packet, [&](const MavFrame& frame) {
          const auto payload = DecodeMavFtp(*UnpackMav<MavFileTransferProtocol>(frame));
          if (payload) client_->Receive(*payload, now_s_);
        });
        at_client_.EndOfDatagram([](const MavFrame&) {});
      });
      client_->Poll(now_s_);
      if (each) each();
    }
    return now_s_ - start_s;
  }

  fs::path root_;
  double now_s_ = 100;
  std::optional<LossyLink> up_;
  std::optional<LossyLink> down_;
  MavParser at_server_;
  MavParser at_client_;
  std::optional<MavFtpServer> server_;
  std::optional<MavFtpClient> client_;
  std::size_t answers_ = 0;
};

TEST_F(Ftp, FilesOfEveryLengthArriveWhole) {
  Connect();
  for (const std::size_t size : {0U, 1U, 238U, 239U, 240U, 478U, 5000U, 300000U}) {
    const Bytes content = MakeFile("a.jpg", size);
    client_->Download("/a.jpg", now_s_);
    EXPECT_EQ(client_->Status(), MavFtpStatus::kRunning);
    Run();
    ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << size << " " << client_->Failure();
    EXPECT_EQ(client_->Data(), content);
    EXPECT_EQ(server_->OpenSessions(), 0U);
  }
  EXPECT_EQ(client_->Repetitions(), 0U) << "nothing was lost";
}

TEST_F(Ftp, ACleanLinkCarriesLittleMoreThanTheFile) {
  Connect();
  MakeFile("a.jpg", 239 * 1000);
  client_->Download("a.jpg", now_s_);
  const double duration_s = Run();
  EXPECT_LT(answers_, 1000U + 10U);
  EXPECT_LT(duration_s, 1.0);
}

TEST_F(Ftp, LossDelayRepetitionAndDamageCostTimeNotBytes) {
  const Bytes content = MakeFile("a.jpg", 100000);
  for (const double loss : {0.05, 0.2, 0.3}) {
    LossyLinkOptions link;
    link.loss = loss;
    link.duplication = 0.1;
    link.corruption = 0.02;
    link.delay_s = 0.02;
    link.jitter_s = 0.02;
    Connect(link);
    client_->Download("a.jpg", now_s_);
    const double duration_s = Run();
    ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
    EXPECT_EQ(client_->Data(), content);
    EXPECT_LT(duration_s, 30) << loss;
    EXPECT_LE(server_->OpenSessions(), 1U);
  }
}

TEST_F(Ftp, ALinkSlowerThanTheTimeoutWorks) {
  const Bytes content = MakeFile("a.jpg", 20000);
  LossyLinkOptions link;
  link.delay_s = 0.3;
  Connect(link);
  client_->Download("a.jpg", now_s_);
  Run();
  ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
  EXPECT_EQ(client_->Data(), content);
}

TEST_F(Ftp, BurstsThatEndEarlyAreContinued) {
  const Bytes content = MakeFile("a.jpg", 50000);
  MavFtpServerOptions server;
  server.burst_packets = 7;
  Connect({}, server);
  client_->Download("a.jpg", now_s_);
  Run();
  ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
  EXPECT_EQ(client_->Data(), content);
}

TEST_F(Ftp, ManyFilesInARowNeverMix) {
  LossyLinkOptions link;
  link.loss = 0.2;
  link.duplication = 0.3;
  link.jitter_s = 0.3;  // stragglers of one file arrive in the next one
  Connect(link);
  for (int i = 0; i < 30; ++i) {
    const std::string name = "low/" + std::to_string(i) + ".jpg";
    const Bytes content = MakeFile(name, static_cast<std::size_t>(3000 + i));
    client_->Download(name, now_s_);
    Run(600, [&] {
      if (client_->Status() != MavFtpStatus::kRunning) now_s_ += 1e-6;
    });
    ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
    ASSERT_EQ(client_->Data(), content) << name;
  }
}

TEST_F(Ftp, ASilentServerIsGivenUpInSeconds) {
  LossyLinkOptions cut;
  cut.is_cut = true;
  Connect(cut);
  client_->Download("a.jpg", now_s_);
  const double duration_s = Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_EQ(client_->Failure(), "FTP of a.jpg: no answer to 7 requests");
  EXPECT_EQ(client_->Repetitions(), 6U);
  EXPECT_GT(duration_s, 3.0);
  EXPECT_LT(duration_s, 5.0);
}

TEST_F(Ftp, ALinkThatBreaksInTheMiddleFailsTheTransfer) {
  MakeFile("a.jpg", 300000);
  Connect();
  client_->Download("a.jpg", now_s_);
  Run(600, [&] {
    if (client_->BytesMissing() < 200000 && !down_->Options().is_cut) {
      LossyLinkOptions cut;
      cut.is_cut = true;
      up_->SetOptions(cut);
      down_->SetOptions(cut);
    }
  });
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_GT(client_->BytesMissing(), 0U);
}

TEST_F(Ftp, WhatIsNotThereSaysSo) {
  Connect();
  client_->Download("none.jpg", now_s_);
  Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_EQ(client_->Failure(), "FTP of none.jpg: the server says: file not found");
}

TEST_F(Ftp, NothingOutsideTheFolderIsServed) {
  Connect();
  fs::create_symlink(root_ / "secret.txt", root_ / "served" / "link.txt");
  fs::create_directory_symlink(root_, root_ / "served" / "up");
  fs::create_directories(root_ / "served_too");
  Write(root_ / "served_too" / "a.txt", Bytes(3, 'x'));
  for (const std::string& path :
       {std::string("../secret.txt"), std::string("/../secret.txt"),
        std::string("low/../../secret.txt"), std::string("//..//secret.txt"),
        (root_ / "secret.txt").string(), std::string("link.txt"), std::string("up/secret.txt"),
        std::string("../served_too/a.txt"), std::string("low"), std::string("."),
        std::string("/dev/zero"), std::string("../secret.txt\0.jpg", 18)}) {
    client_->Download(path, now_s_);
    Run();
    EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed) << path;
    EXPECT_TRUE(client_->Data().empty());
    client_->List(path, now_s_);
    Run();
    for (const MavFtpEntry& entry : client_->Entries()) EXPECT_NE(entry.name, "secret.txt");
  }
  EXPECT_EQ(server_->OpenSessions(), 0U);
}

TEST_F(Ftp, FoldersAreListedInPieces) {
  std::vector<MavFtpEntry> expected;
  for (int i = 100; i < 150; ++i) {
    const std::string name = "low/picture_" + std::to_string(i) + ".jpg";
    MakeFile(name, static_cast<std::size_t>(i));
    expected.push_back({name.substr(4), false, static_cast<std::uint64_t>(i)});
  }
  LossyLinkOptions link;
  link.loss = 0.2;
  Connect(link);
  client_->List("/low", now_s_);
  Run();
  ASSERT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
  EXPECT_EQ(client_->Entries(), expected);
  client_->List("/", now_s_);
  Run();
  EXPECT_EQ(client_->Entries(), (std::vector<MavFtpEntry>{{"low", true, 0}}));
}

TEST_F(Ftp, SessionsOfADeadClientGiveWay) {
  MavFtpServerOptions options;
  options.max_sessions = 1;
  Connect({}, options);
  const Bytes content = MakeFile("a.jpg", 1000);
  MavFtpPayload open;
  open.opcode = MavFtpOpcode::kOpenFileRo;
  open.data = {'a', '.', 'j', 'p', 'g'};
  open.size = 5;
  const MavFileTransferProtocol message = EncodeMavFtp(open, 1, 100);
  const auto leave_open = [&](std::uint8_t component) {
    return server_->Receive(message, MakeMavFrame(message, {255, component, 0}), now_s_);
  };
  leave_open(190);  // the client's own component, before it was started again
  EXPECT_EQ(server_->OpenSessions(), 1U);
  client_->Download("a.jpg", now_s_);
  Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();

  leave_open(7);  // another component: ours may not close it, but it does not last
  client_->Download("a.jpg", now_s_);
  Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_NE(client_->Failure().find("all sessions are in use"), std::string::npos);
  now_s_ += options.session_lifetime_s + 1;
  client_->Download("a.jpg", now_s_);
  Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kDone) << client_->Failure();
  EXPECT_EQ(client_->Data(), content);
}

TEST_F(Ftp, OneClientMayNotUseTheSessionOfAnother) {
  Connect();
  MakeFile("a.jpg", 1000);
  const auto ask = [&](const MavFtpPayload& payload, std::uint8_t component) {
    const MavFileTransferProtocol message = EncodeMavFtp(payload, 1, 100);
    const auto answers =
        server_->Receive(message, MakeMavFrame(message, {255, component, 0}), now_s_);
    return *DecodeMavFtp(answers.at(0));
  };
  MavFtpPayload payload;
  payload.opcode = MavFtpOpcode::kOpenFileRo;
  payload.data = {'a', '.', 'j', 'p', 'g'};
  payload.size = 5;
  EXPECT_EQ(ask(payload, 190).opcode, MavFtpOpcode::kAck);
  for (const MavFtpOpcode opcode :
       {MavFtpOpcode::kReadFile, MavFtpOpcode::kBurstReadFile, MavFtpOpcode::kTerminateSession}) {
    MavFtpPayload other;
    other.sequence = 10;
    other.opcode = opcode;
    other.size = opcode == MavFtpOpcode::kTerminateSession ? 0 : 100;
    EXPECT_EQ(ask(other, 7).Error(), MavFtpError::kInvalidSession);
  }
  MavFtpPayload remove;
  remove.sequence = 20;
  remove.opcode = static_cast<MavFtpOpcode>(8);
  EXPECT_EQ(ask(remove, 190).Error(), MavFtpError::kUnknownCommand);
}

TEST_F(Ftp, AFileThatShrinksWhileItIsReadIsAFailure) {
  MakeFile("a.jpg", 300000);
  Connect();
  client_->Download("a.jpg", now_s_);
  Run(600, [&] {
    if (client_->BytesMissing() < 250000) fs::resize_file(root_ / "served" / "a.jpg", 1000);
  });
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_NE(client_->Failure().find("the file ended at byte"), std::string::npos);
}

TEST_F(Ftp, FilesThatAreTooLongAreRefusedBeforeMemoryIsTaken) {
  MavFtpClientOptions options;
  options.max_file_bytes = 999;
  Connect({}, {}, options);
  MakeFile("a.jpg", 1000);
  client_->Download("a.jpg", now_s_);
  Run();
  EXPECT_EQ(client_->Status(), MavFtpStatus::kFailed);
  EXPECT_NE(client_->Failure().find("1000 bytes, allowed are 999"), std::string::npos);
  EXPECT_EQ(server_->OpenSessions(), 0U) << "the file was closed";
}

TEST_F(Ftp, AbortClosesTheFile) {
  Connect();
  MakeFile("a.jpg", 300000);
  client_->Download("a.jpg", now_s_);
  Run(600, [&] {
    if (client_->BytesMissing() < 200000) client_->Abort("the drone flies home", now_s_);
  });
  EXPECT_EQ(client_->Failure(), "FTP of a.jpg: the drone flies home");
  EXPECT_EQ(server_->OpenSessions(), 0U);
  EXPECT_EQ(client_->NextTimeS(), std::nullopt);
}

TEST_F(Ftp, WrongUseIsAnError) {
  Connect();
  EXPECT_THROW(client_->Download("", now_s_), Error);
  EXPECT_THROW(client_->Download(std::string(240, 'x'), now_s_), Error);
  client_->Download("a", now_s_);
  EXPECT_THROW(client_->Download("b", now_s_), Error);
  EXPECT_THROW(MavFtpServer(root_ / "none", {}), Error);
  MavFtpClientOptions options;
  options.timeout_s = 0;
  EXPECT_THROW(MavFtpClient{options}, UsageError);
}

TEST_F(Ftp, RandomAnswersNeverBreakTheClient) {
  Connect();
  std::mt19937_64 random(9);
  constexpr MavFtpOpcode kOpcodes[] = {
      MavFtpOpcode::kTerminateSession, MavFtpOpcode::kResetSessions, MavFtpOpcode::kListDirectory,
      MavFtpOpcode::kOpenFileRo,       MavFtpOpcode::kReadFile,      MavFtpOpcode::kBurstReadFile};
  for (int run = 0; run < 2000; ++run) {
    if (client_->Status() != MavFtpStatus::kRunning) {
      if (run % 2 == 0) {
        client_->Download("a.jpg", now_s_);
      } else {
        client_->List("a", now_s_);
      }
    }
    for (const MavFtpPayload& request : client_->TakeOutgoing()) {
      MavFtpPayload answer;
      answer.sequence = static_cast<std::uint16_t>(request.sequence + 1 + (random() % 4 == 0));
      answer.session = static_cast<std::uint8_t>(random() % 2);
      answer.opcode = random() % 4 == 0 ? MavFtpOpcode::kNak : MavFtpOpcode::kAck;
      answer.request_opcode = random() % 4 == 0 ? kOpcodes[random() % 6] : request.opcode;
      answer.burst_complete = random() % 2 == 0;
      answer.offset = static_cast<std::uint32_t>(random() % 8 == 0 ? random() : random() % 2000);
      answer.data.resize(random() % 240);
      for (std::uint8_t& byte : answer.data) byte = static_cast<std::uint8_t>(random() % 12);
      if (answer.data.size() > 3) answer.data[2] = answer.data[3] = 0;
      answer.size = static_cast<std::uint8_t>(answer.data.size());
      client_->Receive(answer, now_s_);
      EXPECT_LE(client_->BytesMissing(), client_->Data().size());
    }
    now_s_ += 0.01;
    client_->Poll(now_s_);
  }
}

}  // namespace
}  // namespace colmap_ext
