#include "colmap_ext/util/http_client.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Clock = std::chrono::steady_clock;

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// Each step with what is left of the time.
class Caller {
 public:
  explicit Caller(const HttpCallOptions& options)
      : options_(options), stream_(io_), end_(Clock::now() + Seconds(options.total_timeout_s)) {}

  HttpReply Run(const HttpCall& call) {
    Connect(call);
    const http::request<http::string_body> request = RequestOf(call);
    Await(options_.silence_timeout_s,
          [&](auto done) { http::async_write(stream_, request, done); });
    parser_.body_limit(options_.max_bytes);
    Await(options_.silence_timeout_s,
          [&](auto done) { http::async_read_header(stream_, buffer_, parser_, done); });
    while (!parser_.is_done()) {
      Await(options_.silence_timeout_s,
            [&](auto done) { http::async_read_some(stream_, buffer_, parser_, done); });
    }
    auto& reply = parser_.get();
    return {static_cast<int>(reply.result_int()), std::string(reply.reason()),
            std::move(reply.body())};
  }

 private:
  static http::request<http::string_body> RequestOf(const HttpCall& call) {
    http::request<http::string_body> request(http::string_to_verb(call.method), call.target, 11);
    request.set(http::field::host, call.host + ":" + call.port);
    request.keep_alive(false);
    if (!call.body.empty()) request.set(http::field::content_type, "application/json");
    for (const auto& [name, value] : call.headers) request.set(name, value);
    request.body() = call.body;
    request.prepare_payload();
    return request;
  }

  void Connect(const HttpCall& call) {
    boost::system::error_code error;
    asio::ip::tcp::resolver resolver(io_);
    const auto places = resolver.resolve(call.host, call.port, error);
    if (error) throw Error(error.message());
    Await(options_.connect_timeout_s, [&](auto done) { stream_.async_connect(places, done); });
  }

  // Runs one asynchronous operation in this thread.
  template <typename Start>
  void Await(double timeout_s, const Start& start) {
    boost::system::error_code result;
    stream_.expires_at(std::min(end_, Clock::now() + Seconds(timeout_s)));
    start([&result](const boost::system::error_code& error, const auto&...) { result = error; });
    io_.restart();
    io_.run();
    if (!result) return;
    const std::string received = "after " + std::to_string(parser_.get().body().size()) + " bytes";
    if (result == beast::error::timeout) throw Error("no answer in time, " + received);
    if (result == http::error::partial_message || result == http::error::end_of_stream ||
        result == asio::error::connection_reset) {
      throw Error("the transfer broke off " + received);
    }
    if (result == http::error::body_limit) {
      throw Error("more than the allowed " + std::to_string(options_.max_bytes) + " bytes");
    }
    throw Error(result.message());
  }

  const HttpCallOptions& options_;
  asio::io_context io_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  http::response_parser<http::string_body> parser_;
  Clock::time_point end_;
};

}  // namespace

std::string HttpCallOptions::Check() const {
  for (const double timeout_s : {connect_timeout_s, silence_timeout_s, total_timeout_s}) {
    if (!(timeout_s > 0 && timeout_s <= 1e5)) return "HTTP: a timeout is not in 0 … 1e5 s";
  }
  if (max_bytes == 0) return "HTTP: max_bytes is 0";
  return "";
}

HttpReply CallHttp(const HttpCall& call, const HttpCallOptions& options) {
  ThrowIfInvalid(options.Check());
  return Caller(options).Run(call);
}

}  // namespace colmap_ext
