// One kind of link. Handlers of pending operations keep the object alive; after Close they do
// nothing.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "colmap_ext/mavlink/link.h"

namespace colmap_ext {

class MavTransport : public std::enable_shared_from_this<MavTransport> {
 public:
  MavTransport(boost::asio::io_context* io, MavLinkUrl url) : io_(io), url_(std::move(url)) {}
  virtual ~MavTransport() = default;
  MavTransport(const MavTransport&) = delete;
  MavTransport& operator=(const MavTransport&) = delete;

  void Start(MavLinkEvents events) {
    events_ = std::move(events);
    Open();
  }
  virtual void Send(std::span<const std::uint8_t> bytes) = 0;
  void Close() {
    is_closed_ = true;
    is_open_ = false;
    CloseSocket();
  }

  bool IsOpen() const { return is_open_; }
  virtual std::uint16_t LocalPort() const { return 0; }
  const MavLinkCounts& Counts() const { return counts_; }

 protected:
  virtual void Open() = 0;
  virtual void CloseSocket() = 0;

  // Reports a change once.
  void SetOpen(bool is_open, const std::string& reason) {
    if (is_open == is_open_ && reason == reason_) return;
    is_open_ = is_open;
    reason_ = reason;
    if (events_.changed) events_.changed(is_open, reason);
  }

  boost::asio::io_context* io_;
  MavLinkUrl url_;
  MavLinkEvents events_;
  MavLinkCounts counts_;
  bool is_closed_ = false;

 private:
  bool is_open_ = false;
  std::string reason_;
};

std::shared_ptr<MavTransport> MakeUdpTransport(boost::asio::io_context* io, const MavLinkUrl& url);
std::shared_ptr<MavTransport> MakeTcpTransport(boost::asio::io_context* io, const MavLinkUrl& url);
std::shared_ptr<MavTransport> MakeSerialTransport(boost::asio::io_context* io,
                                                  const MavLinkUrl& url);

}  // namespace colmap_ext
