#include <sys/ioctl.h>

#include <boost/asio/serial_port.hpp>

#include "mavlink/stream_transport.h"

namespace colmap_ext {
namespace {

using boost::asio::serial_port;

class SerialTransport : public StreamTransport<serial_port> {
 public:
  SerialTransport(boost::asio::io_context* io, const MavLinkUrl& url) : StreamTransport(io, url) {}

 protected:
  // A device that is not there may be plugged in later.
  void Open() override {
    serial_port port(*io_);
    try {
      port.open(url_.device);
      port.set_option(serial_port::baud_rate(url_.baud_rate));
      port.set_option(serial_port::character_size(8));
      port.set_option(serial_port::parity(serial_port::parity::none));
      port.set_option(serial_port::stop_bits(serial_port::stop_bits::one));
      port.set_option(serial_port::flow_control(serial_port::flow_control::none));
    } catch (const boost::system::system_error& error) {
      Lose(error.code(), true);
      return;
    }
    ioctl(port.native_handle(), TIOCEXCL);  // two readers would each get half of the bytes
    Use(std::move(port));
  }

  void Lost(const boost::system::error_code& error) override { Lose(error, true); }
};

}  // namespace

std::shared_ptr<MavTransport> MakeSerialTransport(boost::asio::io_context* io,
                                                  const MavLinkUrl& url) {
  return std::make_shared<SerialTransport>(io, url);
}

}  // namespace colmap_ext
