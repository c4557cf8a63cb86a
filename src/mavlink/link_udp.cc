#include <algorithm>
#include <array>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/frame.h"
#include "colmap_ext/util/error.h"
#include "mavlink/transport.h"

namespace colmap_ext {
namespace {

using boost::asio::ip::udp;
using Clock = std::chrono::steady_clock;

// A vehicle whose camera speaks from a port of its own is two peers.
constexpr std::size_t kMaxPeers = 8;
constexpr std::chrono::seconds kPeerLifetime{10};

class UdpTransport : public MavTransport {
 public:
  UdpTransport(boost::asio::io_context* io, const MavLinkUrl& url)
      : MavTransport(io, url), socket_(*io) {}

  void Send(std::span<const std::uint8_t> bytes) override {
    if (!socket_.is_open()) return;
    if (url_.kind == MavLinkKind::kUdpOut) {
      SendTo(bytes, remote_);
      return;
    }
    ForgetSilentPeers();
    if (peers_.empty()) ++counts_.sends_dropped;
    for (const Peer& peer : peers_) SendTo(bytes, peer.address);
  }

  std::uint16_t LocalPort() const override {
    boost::system::error_code error;
    const udp::endpoint local = socket_.local_endpoint(error);
    return error ? 0 : local.port();
  }

 protected:
  void Open() override {
    try {
      udp::resolver resolver(*io_);
      const auto found = resolver.resolve(url_.host, std::to_string(url_.port));
      const udp::endpoint address = found.begin()->endpoint();
      socket_.open(address.protocol());
      if (url_.kind == MavLinkKind::kUdpIn) {
        socket_.bind(address);
      } else {
        remote_ = address;
        socket_.connect(address);  // the kernel drops what others send
      }
      socket_.non_blocking(true);
    } catch (const boost::system::system_error& error) {
      throw Error("cannot open link " + MavLinkUrlText(url_) + ": " + error.code().message() +
                  (error.code() == boost::asio::error::address_in_use
                       ? "; another program listens there"
                       : ""));
    }
    SetOpen(true, "");
    ReceiveNext();
  }

  void CloseSocket() override {
    boost::system::error_code ignored;
    socket_.close(ignored);
  }

 private:
  struct Peer {
    udp::endpoint address;
    Clock::time_point heard;
  };

  void SendTo(std::span<const std::uint8_t> bytes, const udp::endpoint& address) {
    boost::system::error_code error;
    const auto buffer = boost::asio::buffer(bytes.data(), bytes.size());
    const std::size_t sent = url_.kind == MavLinkKind::kUdpOut
                                 ? socket_.send(buffer, 0, error)
                                 : socket_.send_to(buffer, address, 0, error);
    if (error) {
      ++counts_.sends_dropped;
    } else {
      counts_.bytes_sent += sent;
    }
  }

  void ForgetSilentPeers() {
    const Clock::time_point now = Clock::now();
    std::erase_if(peers_, [&](const Peer& peer) { return now - peer.heard > kPeerLifetime; });
  }

  // Whether the sender of the datagram in buffer_ is a peer, or becomes one.
  bool Admit(std::size_t count) {
    if (url_.kind == MavLinkKind::kUdpOut) return true;
    const auto known = std::ranges::find(peers_, sender_, &Peer::address);
    if (known != peers_.end()) {
      known->heard = Clock::now();
      return true;
    }
    ForgetSilentPeers();
    const bool speaks_mavlink =
        count > 0 && (buffer_[0] == kMavMagicV1 || buffer_[0] == kMavMagicV2);
    if (!speaks_mavlink || peers_.size() >= kMaxPeers) return false;
    peers_.push_back({sender_, Clock::now()});
    return true;
  }

  void ReceiveNext() {
    socket_.async_receive_from(boost::asio::buffer(buffer_), sender_,
                               [this, self = shared_from_this()](
                                   const boost::system::error_code& error, std::size_t count) {
                                 if (is_closed_ || error == boost::asio::error::operation_aborted)
                                   return;
                                 // Other errors are about earlier sends, such as "port
                                 // unreachable": the peer is not there yet.
                                 if (!error) {
                                   counts_.bytes_received += count;
                                   if (Admit(count)) {
                                     events_.receive(std::span(buffer_.data(), count), true);
                                   } else {
                                     ++counts_.strangers;
                                   }
                                 }
                                 if (!is_closed_) ReceiveNext();
                               });
  }

  udp::socket socket_;
  udp::endpoint remote_;  // udpout
  udp::endpoint sender_;  // of the datagram in buffer_
  std::vector<Peer> peers_;
  std::array<std::uint8_t, 65536> buffer_;
};

}  // namespace

std::shared_ptr<MavTransport> MakeUdpTransport(boost::asio::io_context* io, const MavLinkUrl& url) {
  return std::make_shared<UdpTransport>(io, url);
}

}  // namespace colmap_ext
