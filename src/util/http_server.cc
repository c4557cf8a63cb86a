#include "colmap_ext/util/http_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Tcp = asio::ip::tcp;

using Json = nlohmann::json;

constexpr std::size_t kMaxHeaderBytes = 8 * 1024;

// A name with which a program on this machine calls this machine.
bool IsLocalHost(std::string host) {
  const auto colon = host.rfind(':');
  if (colon != std::string::npos && host.back() != ']') host.resize(colon);
  return host.empty() || host == "127.0.0.1" || host == "localhost" || host == "[::1]";
}

HttpRequest ToRequest(const http::request<http::string_body>& message) {
  HttpRequest request{std::string(message.method_string()), std::string(message.target()),
                      message.body()};
  for (const auto& field : message) {
    std::string name(field.name_string());
    for (char& letter : name) {
      if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    }
    request.headers.emplace(std::move(name), std::string(field.value()));
  }
  return request;
}

template <typename Body>
void SetHead(const HttpResponse& response, http::response<Body>* message) {
  message->version(11);
  message->result(static_cast<unsigned>(response.status));
  message->set(http::field::content_type, response.content_type);
  for (const auto& [name, value] : response.headers) message->set(name, value);
}

std::chrono::milliseconds Milliseconds(double seconds) {
  return std::chrono::milliseconds(std::llround(seconds * 1e3));
}

}  // namespace

std::string HttpRequest::Header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

HttpResponse HttpError(int status, const std::string& reason) {
  // What a request says may end up in the reason, and it may be no UTF-8.
  const Json json = {{"error", reason}};
  return {status, "application/json",
          json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"};
}

// One client, one request after another.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(Tcp::socket socket, const HttpServerOptions& options,
                 const HttpServer::Handler& handler, std::function<void(HttpConnection*)> closed)
      : stream_(std::move(socket)),
        pause_(stream_.get_executor()),
        options_(options),
        handler_(handler),
        closed_(std::move(closed)) {}

  void Read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(options_.max_body_bytes);
    stream_.expires_after(Milliseconds(options_.idle_timeout_s));
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->OnRead(error); });
  }

  void Close() {
    handler_ = nullptr;
    pieces_.reset();
    pause_.cancel();
    beast::error_code ignored;
    stream_.socket().close(ignored);
    if (closed_) std::exchange(closed_, nullptr)(this);
  }

  void Wake() { pause_.cancel(); }

 private:
  void OnRead(beast::error_code error) {
    if (error == http::error::body_limit) return Refuse(413, "the request is too large");
    if (error == http::error::header_limit) return Refuse(431, "the header is too large");
    const bool is_http_error =
        error && error.category() == http::make_error_code(http::error::bad_method).category();
    if (error == http::error::end_of_stream) return Close();
    if (is_http_error) return Refuse(400, "this is no HTTP: " + error.message());
    if (error) return Close();
    const auto& message = parser_->get();
    keeps_alive_ = message.keep_alive();
    const auto host = message[http::field::host];
    if (!IsLocalHost(std::string(host.data(), host.size()))) {
      return Refuse(403, "only for programs on this machine");
    }
    Handle(ToRequest(message));
  }

  void Handle(const HttpRequest& request) {
    if (!handler_) return;
    stream_.expires_never();
    auto respond = [self = weak_from_this(), is_open = true](HttpResponse response) mutable {
      const auto connection = self.lock();
      if (connection && std::exchange(is_open, false)) connection->Write(std::move(response));
    };
    try {
      handler_(request, respond);
    } catch (const Error& error) {
      respond(HttpError(400, error.what()));
    } catch (const std::exception& error) {
      respond(HttpError(500, error.what()));
    }
  }

  void Refuse(int status, const std::string& reason) {
    keeps_alive_ = false;
    Write(HttpError(status, reason));
  }

  void Write(HttpResponse response) {
    if (response.stream) return WriteStream(std::move(response));
    answer_ = {};
    SetHead(response, &answer_);
    answer_.keep_alive(keeps_alive_);
    answer_.body() = std::move(response.body);
    answer_.prepare_payload();
    stream_.expires_after(Milliseconds(options_.idle_timeout_s));
    http::async_write(stream_, answer_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        if (error) return self->Close();
                        if (self->keeps_alive_) return self->Read();
                        self->SayGoodbye();
                      });
  }

  void WriteStream(HttpResponse response) {
    pieces_ = std::move(response.stream);
    stream_head_ = {};
    SetHead(response, &stream_head_);
    stream_head_.keep_alive(false);
    serializer_.emplace(stream_head_);
    http::async_write_header(stream_, *serializer_,
                             [self = shared_from_this()](beast::error_code error, std::size_t) {
                               self->OnPieceSent(error);
                             });
  }

  void OnPieceSent(beast::error_code error) {
    if (error) return Close();
    if (!pieces_) return;  // closed meanwhile
    piece_ = pieces_->next_piece();
    if (!piece_.empty()) return SendPiece();
    pause_.expires_after(Milliseconds(pieces_->idle_s));
    pause_.async_wait([self = shared_from_this()](beast::error_code woken) {
      if (!self->pieces_) return;
      if (woken) return self->OnPieceSent({});
      self->piece_ = self->pieces_->idle_piece;
      self->SendPiece();
    });
  }

  void SendPiece() {
    asio::async_write(stream_, asio::buffer(piece_),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->OnPieceSent(error);
                      });
  }

  // Closing with something unread would reset the connection, and the answer could get lost.
  void SayGoodbye() {
    beast::error_code ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    stream_.expires_after(std::chrono::seconds(2));
    Drain();
  }

  void Drain() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(4096),
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              if (error) return self->Close();
                              self->Drain();
                            });
  }

  beast::tcp_stream stream_;
  asio::steady_timer pause_;  // of a stream that has nothing to send
  HttpServerOptions options_;
  HttpServer::Handler handler_;
  std::function<void(HttpConnection*)> closed_;
  beast::flat_buffer buffer_{kMaxHeaderBytes + 64 * 1024};
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> answer_;
  http::response<http::empty_body> stream_head_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  std::optional<HttpStream> pieces_;
  std::string piece_;
  bool keeps_alive_ = false;
};

struct HttpServer::Impl : std::enable_shared_from_this<HttpServer::Impl> {
  Impl(asio::io_context& context, const HttpServerOptions& server_options, Handler server_handler)
      : acceptor(context), options(server_options), handler(std::move(server_handler)) {
    const Tcp::endpoint endpoint(asio::ip::address_v4::loopback(), options.port);
    beast::error_code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw Error("cannot listen on 127.0.0.1:" + std::to_string(options.port) + ": " +
                  error.message() + "; choose another port");
    }
  }

  void Accept() {
    acceptor.async_accept([self = shared_from_this()](beast::error_code error, Tcp::socket socket) {
      if (!self->acceptor.is_open()) return;
      if (!error && self->connections.size() < self->options.max_connections) {
        self->Start(std::move(socket));
      }
      self->Accept();
    });
  }

  void Start(Tcp::socket socket) {
    auto connection = std::make_shared<HttpConnection>(
        std::move(socket), options, handler, [self = weak_from_this()](HttpConnection* closed) {
          const auto impl = self.lock();
          if (impl) std::erase_if(impl->connections, [&](auto& c) { return c.get() == closed; });
        });
    connections.insert(connection);
    connection->Read();
  }

  void Close() {
    beast::error_code ignored;
    acceptor.close(ignored);
    for (const auto& connection : std::exchange(connections, {})) connection->Close();
    handler = nullptr;
  }

  Tcp::acceptor acceptor;
  HttpServerOptions options;
  Handler handler;
  std::set<std::shared_ptr<HttpConnection>> connections;
};

HttpServer::HttpServer(asio::io_context& context, const HttpServerOptions& options, Handler handler)
    : impl_(std::make_shared<Impl>(context, options, std::move(handler))) {
  impl_->Accept();
}

HttpServer::~HttpServer() { impl_->Close(); }

void HttpServer::Wake() {
  for (const auto& connection : impl_->connections) connection->Wake();
}

std::uint16_t HttpServer::port() const { return impl_->acceptor.local_endpoint().port(); }

}  // namespace colmap_ext
