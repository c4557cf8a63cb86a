#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <string_view>
#include <utility>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Clock = std::chrono::steady_clock;

struct HttpUrl {
  std::string host;
  std::string port = "80";
  std::string target = "/";
};

HttpUrl ParseHttpUrl(const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  if (!text.starts_with(kScheme)) throw Error("picture " + text + ": not an http:// address");
  std::string_view rest = std::string_view(text).substr(kScheme.size());
  HttpUrl url;
  const std::size_t slash = rest.find('/');
  if (slash != std::string_view::npos) url.target = rest.substr(slash);
  rest = rest.substr(0, slash);
  const std::size_t bracket = rest.rfind(']');
  const std::size_t colon = rest.rfind(':');
  if (colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)) {
    url.port = rest.substr(colon + 1);
    rest = rest.substr(0, colon);
  }
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  url.host = rest;
  const bool is_number =
      !url.port.empty() && url.port.size() <= 5 &&
      std::ranges::all_of(url.port, [](char digit) { return digit >= '0' && digit <= '9'; });
  const bool is_clean = std::ranges::none_of(
      text, [](char letter) { return static_cast<unsigned char>(letter) <= ' '; });
  if (url.host.empty() || !is_number || !is_clean) {
    throw Error("picture " + text + ": not an address of the form http://host:port/path");
  }
  return url;
}

// One request, each step with what is left of the time.
class PictureGet {
 public:
  PictureGet(const std::string& text, const HttpPictureOptions& options)
      : text_(text),
        options_(options),
        stream_(io_),
        end_(Clock::now() + Seconds(options.total_timeout_s)) {}

  std::string Run() {
    const HttpUrl url = ParseHttpUrl(text_);
    Connect(url);
    http::request<http::empty_body> request(http::verb::get, url.target, 11);
    request.set(http::field::host, url.host + ":" + url.port);
    request.set(http::field::connection, "close");
    Await(options_.silence_timeout_s,
          [&](auto done) { http::async_write(stream_, request, done); });
    parser_.body_limit(options_.max_bytes);
    Await(options_.silence_timeout_s,
          [&](auto done) { http::async_read_header(stream_, buffer_, parser_, done); });
    if (parser_.get().result() != http::status::ok) {
      Fail("the server answers " + std::to_string(parser_.get().result_int()) + " " +
           std::string(parser_.get().reason()));
    }
    while (!parser_.is_done()) {
      Await(options_.silence_timeout_s,
            [&](auto done) { http::async_read_some(stream_, buffer_, parser_, done); });
    }
    return std::move(parser_.get().body());
  }

 private:
  static Clock::duration Seconds(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  [[noreturn]] void Fail(const std::string& why) const {
    throw Error("picture " + text_ + ": " + why);
  }

  void Connect(const HttpUrl& url) {
    boost::system::error_code error;
    asio::ip::tcp::resolver resolver(io_);
    const auto places = resolver.resolve(url.host, url.port, error);
    if (error) Fail(error.message());
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
    if (result == beast::error::timeout) Fail("no answer in time, " + received);
    if (result == http::error::partial_message || result == http::error::end_of_stream ||
        result == asio::error::connection_reset) {
      Fail("the transfer broke off " + received);
    }
    if (result == http::error::body_limit) {
      Fail("more than the allowed " + std::to_string(options_.max_bytes) + " bytes");
    }
    Fail(result.message());
  }

  const std::string& text_;
  const HttpPictureOptions& options_;
  asio::io_context io_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  http::response_parser<http::string_body> parser_;
  Clock::time_point end_;
};

}  // namespace

std::string HttpPictureOptions::Check() const {
  for (const double timeout_s : {connect_timeout_s, silence_timeout_s, total_timeout_s}) {
    if (!(timeout_s > 0 && timeout_s <= 1e5)) return "pictures: a timeout is not in 0 … 1e5 s";
  }
  if (max_bytes == 0) return "pictures: max_bytes is 0";
  return "";
}

std::string GetPictureByHttp(const std::string& url, const HttpPictureOptions& options) {
  ThrowIfInvalid(options.Check());
  return PictureGet(url, options).Run();
}

}  // namespace colmap_ext
