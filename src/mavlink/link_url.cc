#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr std::array<std::pair<std::string_view, MavLinkKind>, 5> kSchemes = {{
    {"udpin", MavLinkKind::kUdpIn},
    {"udpout", MavLinkKind::kUdpOut},
    {"tcp", MavLinkKind::kTcp},
    {"tcpin", MavLinkKind::kTcpIn},
    {"serial", MavLinkKind::kSerial},
}};

[[noreturn]] void Refuse(const std::string& text, const std::string& why) {
  throw UsageError("link '" + text + "': " + why +
                   "; say for example udpin://0.0.0.0:14550, udpout://192.168.1.10:14550, "
                   "tcp://127.0.0.1:5760 or serial:///dev/ttyACM0:57600");
}

MavLinkKind KindOf(const std::string& text, std::string_view scheme) {
  for (const auto& [name, kind] : kSchemes) {
    if (name == scheme) return kind;
  }
  Refuse(text, "unknown kind '" + std::string(scheme) + "'");
}

std::uint32_t NumberIn(const std::string& text, std::string_view digits, const std::string& what,
                       std::uint32_t smallest, std::uint32_t greatest) {
  std::uint32_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc() || stop != end || number < smallest || number > greatest) {
    Refuse(text, what + " '" + std::string(digits) + "' is not a number in " +
                     std::to_string(smallest) + " … " + std::to_string(greatest));
  }
  return number;
}

}  // namespace

MavLinkUrl ParseMavLinkUrl(const std::string& text) {
  const std::size_t scheme_end = text.find("://");
  if (scheme_end == std::string::npos) Refuse(text, "there is no '://' in it");
  MavLinkUrl url;
  url.kind = KindOf(text, std::string_view(text).substr(0, scheme_end));
  const std::string_view rest = std::string_view(text).substr(scheme_end + 3);
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos || colon == 0) {
    Refuse(text, url.kind == MavLinkKind::kSerial ? "needs device:baud" : "needs host:port");
  }
  const std::string_view number = rest.substr(colon + 1);
  std::string_view name = rest.substr(0, colon);
  if (url.kind == MavLinkKind::kSerial) {
    url.device = name;
    url.baud_rate = NumberIn(text, number, "baud rate", 1200, 4000000);
    return url;
  }
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    name = name.substr(1, name.size() - 2);
  } else if (name.find(':') != std::string_view::npos) {
    Refuse(text, "an IPv6 address stands in brackets");
  }
  url.host = name;
  const bool listens = url.kind == MavLinkKind::kUdpIn || url.kind == MavLinkKind::kTcpIn;
  url.port = static_cast<std::uint16_t>(NumberIn(text, number, "port", listens ? 0 : 1, 65535));
  return url;
}

std::string MavLinkUrlText(const MavLinkUrl& url) {
  std::string text;
  for (const auto& [name, kind] : kSchemes) {
    if (kind == url.kind) text = std::string(name) + "://";
  }
  if (url.kind == MavLinkKind::kSerial) {
    return text + url.device + ":" + std::to_string(url.baud_rate);
  }
  const bool is_v6 = url.host.find(':') != std::string::npos;
  return text + (is_v6 ? "[" + url.host + "]" : url.host) + ":" + std::to_string(url.port);
}

}  // namespace colmap_ext
