#include <algorithm>
#include <string_view>
#include <utility>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/http_client.h"

namespace colmap_ext {
namespace {

HttpCall ParseHttpUrl(const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  if (!text.starts_with(kScheme)) throw Error("picture " + text + ": not an http:// address");
  std::string_view rest = std::string_view(text).substr(kScheme.size());
  HttpCall call;
  const std::size_t slash = rest.find('/');
  if (slash != std::string_view::npos) call.target = rest.substr(slash);
  rest = rest.substr(0, slash);
  const std::size_t bracket = rest.rfind(']');
  const std::size_t colon = rest.rfind(':');
  if (colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)) {
    call.port = rest.substr(colon + 1);
    rest = rest.substr(0, colon);
  }
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  call.host = rest;
  const bool is_number =
      !call.port.empty() && call.port.size() <= 5 &&
      std::ranges::all_of(call.port, [](char digit) { return digit >= '0' && digit <= '9'; });
  const bool is_clean = std::ranges::none_of(
      text, [](char letter) { return static_cast<unsigned char>(letter) <= ' '; });
  if (call.host.empty() || !is_number || !is_clean) {
    throw Error("picture " + text + ": not an address of the form http://host:port/path");
  }
  return call;
}

}  // namespace

std::string GetPictureByHttp(const std::string& url, const HttpCallOptions& options) {
  ThrowIfInvalid(options.Check());
  const HttpCall call = ParseHttpUrl(url);
  try {
    HttpReply reply = CallHttp(call, options);
    if (reply.status == 200) return std::move(reply.body);
    throw Error("the server answers " + std::to_string(reply.status) + " " + reply.reason);
  } catch (const Error& error) {
    throw Error("picture " + url + ": " + error.what());
  }
}

}  // namespace colmap_ext
