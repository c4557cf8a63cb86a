#include "flight/api_server.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/version.hpp>
#include <chrono>
#include <deque>
#include <set>

#include "flight/api_call.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr std::size_t kMaxConnections = 32;
constexpr std::size_t kMaxHeader = 8192;    // bytes
constexpr std::size_t kKeptEvents = 20000;  // older ones are in the journal
constexpr auto kIdle = std::chrono::seconds(60);
constexpr auto kKeepAlive = std::chrono::seconds(10);

using Response = http::response<http::string_body>;

Response MakeResponse(int status, const Json& body) {
  Response response(static_cast<http::status>(status), 11);
  response.set(http::field::content_type, "application/json");
  response.set(http::field::cache_control, "no-store");
  response.body() = body.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  response.prepare_payload();
  return response;
}

Response Refusal(int status, const std::string& reason) {
  return MakeResponse(status, {{"error", reason}});
}

std::string Header(const http::request<http::string_body>& request, http::field field) {
  const auto value = request.find(field);
  return value == request.end() ? "" : std::string(value->value());
}

ApiRequest Simplify(const http::request<http::string_body>& request) {
  return {std::string(request.method_string()),        std::string(request.target()),
          Header(request, http::field::host),          Header(request, http::field::origin),
          Header(request, http::field::authorization), request.body()};
}

int StatusOf(const boost::system::error_code& error) {
  if (error == http::error::body_limit) return 413;
  if (error == http::error::header_limit) return 431;
  return 400;
}

}  // namespace

struct ApiServer::Impl : std::enable_shared_from_this<ApiServer::Impl> {
  Impl(asio::io_context* given_io, asio::thread_pool* given_workers, std::string given_token,
       ApiBackend given_backend)
      : io(given_io),
        workers(given_workers),
        token(std::move(given_token)),
        backend(std::move(given_backend)),
        acceptor(*io),
        news(*io) {
    news.expires_at(std::chrono::steady_clock::time_point::max());
  }

  void Listen(int port);
  asio::awaitable<void> Accept();
  asio::awaitable<void> Serve(tcp::socket socket);
  asio::awaitable<bool> Answer(beast::tcp_stream* stream,
                               const http::request<http::string_body>& request);
  asio::awaitable<Response> Perform(ApiCall* call);
  asio::awaitable<void> LoadInWorker(FlightRequest* request, std::string* problem);
  asio::awaitable<void> StreamEvents(beast::tcp_stream* stream, std::size_t since);

  asio::io_context* io;
  asio::thread_pool* workers;
  std::string token;
  ApiBackend backend;
  tcp::acceptor acceptor;
  asio::steady_timer news;  // cancelled when there is an event
  std::size_t connections = 0;
  std::size_t first_event = 0;  // number of events.front()
  std::deque<std::string> events;
};

void ApiServer::Impl::Listen(int port) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), static_cast<unsigned short>(port));
  boost::system::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(16, error);
  if (error) {
    throw Error("127.0.0.1:" + std::to_string(port) + ": cannot listen: " + error.message());
  }
}

asio::awaitable<void> ApiServer::Impl::Accept() {
  const auto self = shared_from_this();
  while (acceptor.is_open()) {
    boost::system::error_code error;
    tcp::socket socket =
        co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, error));
    if (error == asio::error::operation_aborted) co_return;
    if (error || connections >= kMaxConnections) continue;
    asio::co_spawn(*io, Serve(std::move(socket)), asio::detached);
  }
}

asio::awaitable<void> ApiServer::Impl::Serve(tcp::socket socket) {
  const auto self = shared_from_this();
  ++connections;
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer;
  bool goes_on = true;
  while (goes_on) {
    http::request_parser<http::string_body> parser;
    parser.body_limit(kMaxApiBody);
    parser.header_limit(kMaxHeader);
    stream.expires_after(kIdle);
    boost::system::error_code error;
    co_await http::async_read(stream, buffer, parser,
                              asio::redirect_error(asio::use_awaitable, error));
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error == asio::error::operation_aborted || error == asio::error::connection_reset) {
      break;
    }
    if (error) {
      Response response = Refusal(StatusOf(error), "not a request: " + error.message());
      response.keep_alive(false);
      co_await http::async_write(stream, response,
                                 asio::redirect_error(asio::use_awaitable, error));
      break;
    }
    goes_on = co_await Answer(&stream, parser.get());
  }
  boost::system::error_code ignored;
  stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
  --connections;
}

// Whether the connection may be used again.
asio::awaitable<bool> ApiServer::Impl::Answer(beast::tcp_stream* stream,
                                              const http::request<http::string_body>& request) {
  Response response;
  try {
    ApiCall call = ParseApiCall(Simplify(request), token, backend.mission());
    if (call.kind == ApiCall::Kind::kEvents) {
      co_await StreamEvents(stream, call.since);
      co_return false;
    }
    response = co_await Perform(&call);
  } catch (const ApiError& error) {
    response = Refusal(error.status(), error.what());
  } catch (const std::exception& error) {
    response = Refusal(500, error.what());
  }
  response.keep_alive(request.keep_alive());
  boost::system::error_code error;
  co_await http::async_write(*stream, response, asio::redirect_error(asio::use_awaitable, error));
  co_return !error && response.keep_alive();
}

asio::awaitable<Response> ApiServer::Impl::Perform(ApiCall* call) {
  if (call->kind == ApiCall::Kind::kStatus) co_return MakeResponse(200, backend.status());
  if (call->needs_surface) {
    std::string problem;
    co_await LoadInWorker(&call->request, &problem);
    if (!problem.empty()) co_return Refusal(400, problem);
  }
  const FlightReply reply = backend.request(call->request);
  if (!reply.is_accepted) co_return Refusal(409, reply.reason);
  co_return MakeResponse(200, backend.status());
}

// Reading a mesh takes longer than the vehicle may wait for its heartbeat.
asio::awaitable<void> ApiServer::Impl::LoadInWorker(FlightRequest* request, std::string* problem) {
  asio::steady_timer done(*io);
  done.expires_at(std::chrono::steady_clock::time_point::max());
  asio::post(*workers, [this, request, problem, &done] {
    try {
      LoadSurface(request);
    } catch (const std::exception& error) {
      *problem = error.what();
    }
    asio::post(*io, [&done] { done.expires_at(std::chrono::steady_clock::time_point::min()); });
  });
  boost::system::error_code ignored;
  co_await done.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
}

asio::awaitable<void> ApiServer::Impl::StreamEvents(beast::tcp_stream* stream, std::size_t since) {
  http::response<http::empty_body> head(http::status::ok, 11);
  head.set(http::field::content_type, "text/event-stream");
  head.set(http::field::cache_control, "no-store");
  head.keep_alive(false);
  stream->expires_never();
  http::response_serializer<http::empty_body> serializer(head);
  boost::system::error_code error;
  co_await http::async_write_header(*stream, serializer,
                                    asio::redirect_error(asio::use_awaitable, error));
  std::size_t next = since;
  while (!error) {
    std::string text;
    next = std::max(next, first_event);
    for (; next < first_event + events.size() && text.size() < kMaxHeader; ++next) {
      text += "id: " + std::to_string(next) + "\ndata: " + events[next - first_event] + "\n\n";
    }
    if (text.empty()) {
      // Woken by the next event, or else to find out that nobody listens any more.
      asio::steady_timer timeout(*io, kKeepAlive);
      timeout.async_wait([this](const boost::system::error_code& e) {
        if (!e) news.cancel();
      });
      boost::system::error_code ignored;
      co_await news.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
      if (next >= first_event + events.size()) text = ": waiting\n\n";
      if (next < first_event + events.size()) continue;
    }
    co_await asio::async_write(*stream, asio::buffer(text),
                               asio::redirect_error(asio::use_awaitable, error));
  }
}

ApiServer::ApiServer(asio::io_context* io, asio::thread_pool* workers, int port, std::string token,
                     ApiBackend backend)
    : impl_(std::make_shared<Impl>(io, workers, std::move(token), std::move(backend))) {
  impl_->Listen(port);
  asio::co_spawn(*io, impl_->Accept(), asio::detached);
}

ApiServer::~ApiServer() {
  boost::system::error_code ignored;
  impl_->acceptor.close(ignored);
  impl_->news.cancel();
}

int ApiServer::port() const { return impl_->acceptor.local_endpoint().port(); }

void ApiServer::Publish(const Json& event) {
  impl_->events.push_back(event.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (impl_->events.size() > kKeptEvents) {
    impl_->events.pop_front();
    ++impl_->first_event;
  }
  impl_->news.cancel();
}

}  // namespace colmap_ext
