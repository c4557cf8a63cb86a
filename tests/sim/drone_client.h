// Clients for tests of a whole simulated drone: HTTP and MAVLink over UDP, both blocking.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext::test {

struct HttpAnswer {
  int status = 0;
  std::string body;
};

inline HttpAnswer HttpExchange(int port, const std::string& method, const std::string& target,
                               const std::string& body = "") {
  namespace asio = boost::asio;
  asio::io_context io;
  asio::ip::tcp::socket socket(io);
  socket.connect({asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
  const std::string request = method + " " + target +
                              " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n"
                              "Content-Length: " +
                              std::to_string(body.size()) + "\r\n\r\n" + body;
  boost::system::error_code error;
  asio::write(socket, asio::buffer(request), error);
  std::string answer;
  asio::read(socket, asio::dynamic_buffer(answer), error);
  const auto end = answer.find("\r\n\r\n");
  if (end == std::string::npos) return {};
  return {std::stoi(answer.substr(9, 3)), answer.substr(end + 4)};
}

inline Json HttpGetJson(int port, const std::string& target) {
  return Json::parse(HttpExchange(port, "GET", target).body, nullptr, false);
}

// A ground station behind a UDP port that the drone sends to.
class UdpPeer {
 public:
  UdpPeer() : socket_(io_, {boost::asio::ip::address_v4::loopback(), 0}) {
    socket_.non_blocking(true);
  }
  int port() const { return socket_.local_endpoint().port(); }
  std::string Url() const { return "udpout://127.0.0.1:" + std::to_string(port()); }

  template <typename Message>
  void Send(const Message& message) {
    const std::vector<std::uint8_t> bytes = MavFrameBytes(sender_.Next(message));
    boost::system::error_code ignored;
    socket_.send_to(boost::asio::buffer(bytes), drone_, 0, ignored);
  }

  // Reads packets until `is_enough(frame)`; false after `most_s` wall seconds.
  bool ReadUntil(const std::function<bool(const MavFrame&)>& is_enough, double most_s) {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::milliseconds(static_cast<int>(most_s * 1e3));
    bool is_done = false;
    std::array<std::uint8_t, 2048> bytes{};
    while (!is_done && std::chrono::steady_clock::now() < end) {
      boost::system::error_code error;
      const std::size_t size = socket_.receive_from(boost::asio::buffer(bytes), drone_, 0, error);
      if (error) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      const auto take = [&](const MavFrame& frame) { is_done = is_done || is_enough(frame); };
      parser_.Feed(std::span(bytes.data(), size), take);
      parser_.EndOfDatagram(take);
    }
    return is_done;
  }
  template <typename Message>
  bool Hears(double most_s) {
    return ReadUntil([](const MavFrame& frame) { return frame.message_id == Message::kId; },
                     most_s);
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ip::udp::socket socket_;
  boost::asio::ip::udp::endpoint drone_;
  MavSender sender_{255, 190};
  MavParser parser_;
};

}  // namespace colmap_ext::test
