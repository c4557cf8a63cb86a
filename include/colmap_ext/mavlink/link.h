// Where bytes of MAVLink come from and go to: UDP, TCP and serial ports, all on one event loop.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace boost::asio {
class io_context;
}

namespace colmap_ext {

enum class MavLinkKind { kUdpIn, kUdpOut, kTcp, kTcpIn, kSerial };

// udpin://0.0.0.0:14550          listens; answers to everyone whom it has heard of late
// udpout://192.168.1.10:14550    sends to one address and listens to it alone
// tcp://127.0.0.1:5760           connects, again and again
// tcpin://127.0.0.1:5760         lets one peer connect; a new one replaces it
// serial:///dev/ttyACM0:57600    device and baud rate, 8N1 without flow control
struct MavLinkUrl {
  MavLinkKind kind = MavLinkKind::kUdpIn;
  std::string host;    // name or address; empty for serial
  std::string device;  // serial only
  std::uint16_t port = 0;
  std::uint32_t baud_rate = 0;
  bool operator==(const MavLinkUrl&) const = default;
};

// Throws UsageError. IPv6 addresses stand in brackets. Port 0 (udpin, tcpin) takes a free one.
MavLinkUrl ParseMavLinkUrl(const std::string& text);
std::string MavLinkUrlText(const MavLinkUrl& url);

// Called on the event loop's thread. May call Send and Close.
struct MavLinkEvents {
  // `ends_datagram`: nothing that follows continues these bytes (see MavParser::EndOfDatagram).
  std::function<void(std::span<const std::uint8_t> bytes, bool ends_datagram)> receive;
  // The link was opened, or was lost and why ("connection refused"); one call for one cause, not
  // for every attempt. What was received in part before is void. May be empty.
  std::function<void(bool is_open, const std::string& reason)> changed;
};

struct MavLinkCounts {
  std::uint64_t bytes_received = 0;
  std::uint64_t bytes_sent = 0;
  std::uint64_t sends_dropped = 0;  // not connected, nobody to answer to, or too much waiting
  std::uint64_t strangers = 0;      // datagrams that are no MAVLink, or from one peer too many
};

class MavTransport;

// One link. All calls on the thread that runs the event loop, which must outlive the link. Closed
// by its destructor; no event comes after that. A link that was lost is opened again, with pauses
// from 0.5 to 5 s; what was to be sent while it was lost is dropped, never sent later: an old
// command is a wrong command.
class MavLink {
 public:
  MavLink(boost::asio::io_context* io, const MavLinkUrl& url);
  ~MavLink();
  MavLink(const MavLink&) = delete;
  MavLink& operator=(const MavLink&) = delete;

  // Throws Error when the address cannot be listened on or its name is not known (UDP, tcpin).
  void Start(MavLinkEvents events);
  // Takes one packet or more. Never blocks, never throws.
  void Send(std::span<const std::uint8_t> bytes);
  void Close();

  bool IsOpen() const;  // UDP: always between Start and Close
  // The port that is listened on, of use after port 0; 0 for others.
  std::uint16_t LocalPort() const;
  const MavLinkCounts& Counts() const;

 private:
  std::shared_ptr<MavTransport> transport_;
};

}  // namespace colmap_ext
