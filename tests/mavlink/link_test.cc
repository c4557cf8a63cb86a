#include "colmap_ext/mavlink/link.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

using Bytes = std::vector<std::uint8_t>;
using boost::asio::ip::udp;

TEST(MavLinkUrl, EveryKindIsUnderstoodAndComesBackAsText) {
  for (const char* text :
       {"udpin://0.0.0.0:14550", "udpout://drone.local:14550", "tcp://127.0.0.1:5760",
        "tcpin://[::1]:5760", "serial:///dev/ttyACM0:57600",
        "serial:///dev/serial/by-id/usb-a:b-if00:921600"}) {
    EXPECT_EQ(MavLinkUrlText(ParseMavLinkUrl(text)), text);
  }
  const MavLinkUrl serial = ParseMavLinkUrl("serial:///dev/ttyACM0:57600");
  EXPECT_EQ(serial.device, "/dev/ttyACM0");
  EXPECT_EQ(serial.baud_rate, 57600U);
  EXPECT_EQ(ParseMavLinkUrl("tcp://[fe80::1]:1").host, "fe80::1");
}

TEST(MavLinkUrl, WrongOnesAreRefusedWithOneLineThatSaysWhatToDo) {
  for (const char* text :
       {"", "udpin", "udpin://", "udpin://:14550", "udpin://0.0.0.0",
        "udpin://0.0.0.0:", "udpin://0.0.0.0:x", "udpin://0.0.0.0:70000", "udpout://a:0",
        "udpin://0.0.0.0:1x", "udp://0.0.0.0:14550", "tcp://::1:5760", "serial:///dev/ttyACM0",
        "serial:///dev/tty:9", "tcp://a:-1"}) {
    try {
      ParseMavLinkUrl(text);
      FAIL() << text;
    } catch (const UsageError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos);
      EXPECT_NE(message.find("udpin://0.0.0.0:14550"), std::string::npos) << message;
    }
  }
}

// One link and what it reported.
struct End {
  End(boost::asio::io_context* io, const MavLinkUrl& url) : link(io, url) {}
  void Start() {
    link.Start({[this](std::span<const std::uint8_t> bytes, bool ends_datagram) {
                  received.insert(received.end(), bytes.begin(), bytes.end());
                  datagrams += ends_datagram ? 1 : 0;
                },
                [this](bool is_open, const std::string& reason) {
                  changes.push_back(is_open ? "open" : reason);
                }});
  }
  MavLink link;
  Bytes received;
  int datagrams = 0;
  std::vector<std::string> changes;
};

class Links : public testing::Test {
 protected:
  bool RunUntil(const std::function<bool()>& is_done, double limit_s = 10) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
    while (!is_done() && std::chrono::steady_clock::now() < end) {
      io_.restart();
      io_.run_for(std::chrono::milliseconds(5));
    }
    return is_done();
  }
  void RunFor(double duration_s) {
    RunUntil([] { return false; }, duration_s);
  }
  static MavLinkUrl At(const std::string& kind, std::uint16_t port) {
    return ParseMavLinkUrl(kind + "://127.0.0.1:" + std::to_string(port));
  }

  boost::asio::io_context io_;
  const Bytes heartbeat_ = PackMav(MavHeartbeat{}, {1, 1, 0});
  const Bytes ping_ = PackMav(MavPing{}, {255, 190, 0});
};

TEST_F(Links, UdpCarriesBothWays) {
  End ground(&io_, At("udpin", 0));
  ground.Start();
  ASSERT_NE(ground.link.LocalPort(), 0);
  ground.link.Send(ping_);
  EXPECT_EQ(ground.link.Counts().sends_dropped, 1U) << "nobody is known yet";
  End vehicle(&io_, At("udpout", ground.link.LocalPort()));
  vehicle.Start();
  EXPECT_TRUE(vehicle.link.IsOpen());
  vehicle.link.Send(heartbeat_);
  ASSERT_TRUE(RunUntil([&] { return ground.received == heartbeat_; }));
  EXPECT_EQ(ground.datagrams, 1);
  ground.link.Send(ping_);
  ASSERT_TRUE(RunUntil([&] { return vehicle.received == ping_; }));
  EXPECT_EQ(vehicle.link.Counts().bytes_sent, heartbeat_.size());
  EXPECT_EQ(vehicle.link.Counts().bytes_received, ping_.size());
}

TEST_F(Links, UdpInAnswersEveryPeerAndNoStranger) {
  End ground(&io_, At("udpin", 0));
  ground.Start();
  std::vector<std::unique_ptr<End>> peers;
  for (int i = 0; i < 10; ++i) {
    peers.push_back(std::make_unique<End>(&io_, At("udpout", ground.link.LocalPort())));
    peers.back()->Start();
  }
  peers[0]->link.Send(Bytes{'G', 'E', 'T', ' '});
  peers[0]->link.Send(Bytes{});
  ASSERT_TRUE(RunUntil([&] { return ground.link.Counts().strangers == 2; }));
  EXPECT_TRUE(ground.received.empty());
  for (const auto& peer : peers) peer->link.Send(heartbeat_);
  ASSERT_TRUE(RunUntil([&] { return ground.link.Counts().strangers == 4; }))
      << "eight peers are admitted, the last two are not";
  ground.link.Send(ping_);
  ASSERT_TRUE(RunUntil([&] { return peers[7]->received == ping_; }));
  RunFor(0.05);
  EXPECT_TRUE(peers[8]->received.empty());
}

TEST_F(Links, UdpOutHearsNobodyElse) {
  End ground(&io_, At("udpin", 0));
  ground.Start();
  End vehicle(&io_, At("udpout", ground.link.LocalPort()));
  vehicle.Start();
  udp::socket stranger(io_, udp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0));
  vehicle.link.Send(heartbeat_);
  stranger.send_to(
      boost::asio::buffer(ping_),
      udp::endpoint(boost::asio::ip::make_address("127.0.0.1"), vehicle.link.LocalPort()));
  RunFor(0.1);
  EXPECT_TRUE(vehicle.received.empty());
}

TEST_F(Links, UdpOutGoesOnWhenThePeerComesLater) {
  End probe(&io_, At("udpin", 0));
  probe.Start();
  const std::uint16_t port = probe.link.LocalPort();
  probe.link.Close();
  End vehicle(&io_, At("udpout", port));
  vehicle.Start();
  for (int i = 0; i < 5; ++i) {  // each is answered by "port unreachable"
    vehicle.link.Send(heartbeat_);
    RunFor(0.01);
  }
  End ground(&io_, At("udpin", port));
  ground.Start();
  ASSERT_TRUE(RunUntil([&] {
    vehicle.link.Send(heartbeat_);
    return !ground.received.empty();
  }));
  ground.link.Send(ping_);
  EXPECT_TRUE(RunUntil([&] { return !vehicle.received.empty(); }));
}

TEST_F(Links, APortThatIsTakenIsAnErrorThatSaysSo) {
  End first(&io_, At("udpin", 0));
  first.Start();
  End second(&io_, At("udpin", first.link.LocalPort()));
  try {
    second.Start();
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("another program listens"), std::string::npos);
  }
  End nowhere(&io_, ParseMavLinkUrl("udpout://no-such-host.invalid:14550"));
  EXPECT_THROW(nowhere.Start(), Error);
}

TEST_F(Links, TcpCarriesBothWaysInOrder) {
  End server(&io_, At("tcpin", 0));
  server.Start();
  End client(&io_, At("tcp", server.link.LocalPort()));
  client.Start();
  client.link.Send(heartbeat_);
  EXPECT_EQ(client.link.Counts().sends_dropped, 1U) << "not connected yet";
  ASSERT_TRUE(RunUntil([&] { return client.link.IsOpen() && server.link.IsOpen(); }));
  Bytes expected;
  for (std::uint8_t i = 0; i < 200; ++i) {
    const Bytes packet = PackMav(MavHeartbeat{}, {1, 1, i});
    client.link.Send(packet);
    expected.insert(expected.end(), packet.begin(), packet.end());
  }
  server.link.Send(ping_);
  ASSERT_TRUE(RunUntil([&] { return server.received == expected && client.received == ping_; }));
  EXPECT_EQ(server.datagrams, 0);
}

TEST_F(Links, TcpConnectsAgainAndNeverSendsWhatIsOld) {
  End server(&io_, At("tcpin", 0));
  server.Start();
  const std::uint16_t port = server.link.LocalPort();
  End client(&io_, At("tcp", port));
  client.Start();
  ASSERT_TRUE(RunUntil([&] { return client.link.IsOpen() && server.link.IsOpen(); }));
  server.link.Close();
  ASSERT_TRUE(RunUntil([&] { return !client.link.IsOpen(); }));
  client.link.Send(heartbeat_);
  RunFor(0.7);  // one attempt fails meanwhile
  End again(&io_, At("tcpin", port));
  again.Start();
  ASSERT_TRUE(RunUntil([&] { return client.link.IsOpen() && again.link.IsOpen(); }));
  client.link.Send(ping_);
  ASSERT_TRUE(RunUntil([&] { return again.received.size() >= ping_.size(); }));
  EXPECT_EQ(again.received, ping_);
  ASSERT_GE(client.changes.size(), 3U);
  EXPECT_EQ(client.changes.front(), "open");
  EXPECT_EQ(client.changes.back(), "open");
  EXPECT_LE(client.changes.size(), 4U) << "one report for one cause";
}

TEST_F(Links, TcpServerTurnsToTheNewestClient) {
  End server(&io_, At("tcpin", 0));
  server.Start();
  auto first = std::make_unique<End>(&io_, At("tcp", server.link.LocalPort()));
  first->Start();
  ASSERT_TRUE(RunUntil([&] { return server.link.IsOpen() && first->link.IsOpen(); }));
  first.reset();
  End second(&io_, At("tcp", server.link.LocalPort()));
  second.Start();
  ASSERT_TRUE(RunUntil([&] {
    server.link.Send(ping_);
    return !second.received.empty();
  }));
}

TEST_F(Links, TcpDropsRatherThanPilesUp) {
  End server(&io_, At("tcpin", 0));
  server.Start();
  End client(&io_, At("tcp", server.link.LocalPort()));
  client.Start();
  ASSERT_TRUE(RunUntil([&] { return client.link.IsOpen(); }));
  const Bytes packet(1000, 0);
  for (int i = 0; i < 1000; ++i) client.link.Send(packet);
  EXPECT_GT(client.link.Counts().sends_dropped, 500U);
  ASSERT_TRUE(RunUntil([&] { return server.received.size() > 200000; }));
}

TEST_F(Links, SerialCarriesBothWaysAndComesBackAfterUnplugging) {
  int master = -1;
  int slave = -1;
  char name[256];
  ASSERT_EQ(openpty(&master, &slave, name, nullptr, nullptr), 0);
  MavLinkUrl url;
  url.kind = MavLinkKind::kSerial;
  url.device = name;
  url.baud_rate = 57600;
  End vehicle(&io_, url);
  vehicle.Start();
  ASSERT_TRUE(vehicle.link.IsOpen());
  ASSERT_EQ(write(master, heartbeat_.data(), heartbeat_.size()),
            static_cast<ssize_t>(heartbeat_.size()));
  ASSERT_TRUE(RunUntil([&] { return vehicle.received == heartbeat_; }));
  vehicle.link.Send(ping_);
  RunFor(0.05);
  Bytes bytes(1000);
  bytes.resize(static_cast<std::size_t>(read(master, bytes.data(), bytes.size())));
  EXPECT_EQ(bytes, ping_);
  close(master);
  close(slave);
  ASSERT_TRUE(RunUntil([&] { return !vehicle.link.IsOpen(); }));
  EXPECT_EQ(vehicle.changes.size(), 2U);
}

TEST_F(Links, ASerialDeviceThatIsNotThereIsReportedOnce) {
  End vehicle(&io_, ParseMavLinkUrl("serial:///dev/no-such-device:57600"));
  vehicle.Start();
  RunFor(1.7);  // three attempts
  EXPECT_EQ(vehicle.changes, std::vector<std::string>{"No such file or directory"});
  vehicle.link.Send(heartbeat_);
  EXPECT_EQ(vehicle.link.Counts().sends_dropped, 1U);
}

TEST_F(Links, NoEventComesAfterClosing) {
  End ground(&io_, At("udpin", 0));
  ground.Start();
  {
    End vehicle(&io_, At("udpout", ground.link.LocalPort()));
    vehicle.Start();
    vehicle.link.Send(heartbeat_);
  }
  ground.link.Close();
  RunFor(0.05);
  EXPECT_TRUE(ground.received.empty());
  EXPECT_FALSE(ground.link.IsOpen());
  ground.link.Send(ping_);
  io_.restart();
  EXPECT_EQ(io_.run_for(std::chrono::milliseconds(50)), 0U) << "something still waits";
}

}  // namespace
}  // namespace colmap_ext
