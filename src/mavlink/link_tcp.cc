#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>

#include "colmap_ext/util/error.h"
#include "mavlink/stream_transport.h"

namespace colmap_ext {
namespace {

using boost::asio::ip::tcp;

void SetLowLatency(tcp::socket* socket) {
  boost::system::error_code ignored;
  socket->set_option(tcp::no_delay(true), ignored);
  socket->set_option(boost::asio::socket_base::keep_alive(true), ignored);
}

class TcpClient : public StreamTransport<tcp::socket> {
 public:
  TcpClient(boost::asio::io_context* io, const MavLinkUrl& url)
      : StreamTransport(io, url), resolver_(*io), socket_(*io) {}

 protected:
  void Open() override {
    resolver_.async_resolve(url_.host, std::to_string(url_.port),
                            [this, self = shared_from_this()](
                                const boost::system::error_code& error, const auto& found) {
                              if (is_closed_) return;
                              if (error) {
                                Lose(error, true);
                              } else {
                                Connect(found);
                              }
                            });
  }

  void Lost(const boost::system::error_code& error) override { Lose(error, true); }

  void CloseSocket() override {
    resolver_.cancel();
    boost::system::error_code ignored;
    socket_.close(ignored);
    StreamTransport::CloseSocket();
  }

 private:
  void Connect(const tcp::resolver::results_type& found) {
    boost::asio::async_connect(
        socket_, found,
        [this, self = shared_from_this()](const boost::system::error_code& error, const auto&) {
          if (is_closed_) return;
          if (error) {
            Lose(error, true);
            return;
          }
          SetLowLatency(&socket_);
          Use(std::move(socket_));
          socket_ = tcp::socket(*io_);
        });
  }

  tcp::resolver resolver_;
  tcp::socket socket_;  // while it connects
};

class TcpServer : public StreamTransport<tcp::socket> {
 public:
  TcpServer(boost::asio::io_context* io, const MavLinkUrl& url)
      : StreamTransport(io, url), acceptor_(*io) {}

  std::uint16_t LocalPort() const override {
    boost::system::error_code error;
    const tcp::endpoint local = acceptor_.local_endpoint(error);
    return error ? 0 : local.port();
  }

 protected:
  void Open() override {
    try {
      tcp::resolver resolver(*io_);
      const tcp::endpoint address =
          resolver.resolve(url_.host, std::to_string(url_.port)).begin()->endpoint();
      acceptor_.open(address.protocol());
      acceptor_.set_option(tcp::acceptor::reuse_address(true));
      acceptor_.bind(address);
      acceptor_.listen();
    } catch (const boost::system::system_error& error) {
      throw Error("cannot open link " + MavLinkUrlText(url_) + ": " + error.code().message());
    }
    AcceptNext();
  }

  void Lost(const boost::system::error_code& error) override { Lose(error, false); }

  void CloseSocket() override {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    StreamTransport::CloseSocket();
  }

 private:
  void AcceptNext() {
    acceptor_.async_accept([this, self = shared_from_this()](const boost::system::error_code& error,
                                                             tcp::socket socket) {
      if (is_closed_ || error == boost::asio::error::operation_aborted) return;
      if (!error) {
        SetLowLatency(&socket);
        if (IsOpen()) Lose(boost::asio::error::connection_aborted, false);
        Use(std::move(socket));
      }
      if (!is_closed_) AcceptNext();
    });
  }

  tcp::acceptor acceptor_;
};

}  // namespace

std::shared_ptr<MavTransport> MakeTcpTransport(boost::asio::io_context* io, const MavLinkUrl& url) {
  if (url.kind == MavLinkKind::kTcpIn) return std::make_shared<TcpServer>(io, url);
  return std::make_shared<TcpClient>(io, url);
}

}  // namespace colmap_ext
