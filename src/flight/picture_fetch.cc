#include "flight/picture_fetch.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstdio>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr auto kTimeout = std::chrono::seconds(30);
constexpr std::uint64_t kMaxPicture = std::uint64_t{200} << 20;  // bytes

void Replace(const std::string& mark, const std::string& value, std::string* text) {
  for (std::size_t at = text->find(mark); at != std::string::npos; at = text->find(mark, at)) {
    text->replace(at, mark.size(), value);
    at += value.size();
  }
}

struct Url {
  std::string host, port, path;
};

Url ParseHttpUrl(const std::string& text) {
  const std::string kScheme = "http://";
  if (!text.starts_with(kScheme)) throw Error(text + ": only http:// is fetched from here");
  const std::size_t slash = text.find('/', kScheme.size());
  const std::string authority = text.substr(kScheme.size(), slash - kScheme.size());
  const std::size_t colon = authority.rfind(':');
  return {authority.substr(0, colon),
          colon == std::string::npos ? "80" : authority.substr(colon + 1),
          slash == std::string::npos ? "/" : text.substr(slash)};
}

// Runs one asynchronous operation with the stream's timeout, in this thread.
template <typename Start>
void Await(asio::io_context* io, const std::string& url, const Start& start) {
  boost::system::error_code result = asio::error::would_block;
  start([&result](const boost::system::error_code& error, const auto&...) { result = error; });
  io->restart();
  io->run();
  if (result) throw Error(url + ": " + result.message());
}

std::string HttpGet(const std::string& text) {
  const Url url = ParseHttpUrl(text);
  asio::io_context io;
  boost::system::error_code error;
  asio::ip::tcp::resolver resolver(io);
  const auto places = resolver.resolve(url.host, url.port, error);
  if (error) throw Error(text + ": " + error.message());
  beast::tcp_stream stream(io);
  stream.expires_after(kTimeout);
  Await(&io, text, [&](auto done) { stream.async_connect(places, done); });
  http::request<http::empty_body> request(http::verb::get, url.path, 11);
  request.set(http::field::host, url.host + ":" + url.port);
  request.keep_alive(false);
  Await(&io, text, [&](auto done) { http::async_write(stream, request, done); });
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(kMaxPicture);
  Await(&io, text, [&](auto done) { http::async_read(stream, buffer, parser, done); });
  if (parser.get().result() != http::status::ok) {
    throw Error(text + ": HTTP " + std::to_string(parser.get().result_int()));
  }
  return std::move(parser.get().body());
}

}  // namespace

std::string PictureUrl(const FetchRequest& request, const std::string& pattern) {
  if (pattern.empty()) return request.full_resolution ? "" : request.capture.file_url;
  std::string url = pattern;
  char digits[16];
  std::snprintf(digits, sizeof digits, "%05d", request.capture.record.index);
  Replace("{index5}", digits, &url);
  Replace("{index}", std::to_string(request.capture.record.index), &url);
  Replace("{resolution}", request.full_resolution ? "full" : "low", &url);
  return url;
}

std::string FetchPicture(const FetchRequest& request, const PictureSourceOptions& options) {
  const std::string url = PictureUrl(request, options.url);
  if (url.empty()) {
    throw Error(request.photo +
                ": nobody says where the camera keeps it; give --picture_url or --capture_folder");
  }
  return HttpGet(url);
}

}  // namespace colmap_ext
