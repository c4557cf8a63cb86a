#include "colmap_ext/flight/flight_client.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <istream>
#include <string_view>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/http_client.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr const char* kHost = "127.0.0.1";
constexpr double kPatienceS = 60;  // a mission with a large surface takes seconds to load

tcp::endpoint EndpointOf(const DaemonAddress& address) {
  return {asio::ip::address_v4::loopback(), static_cast<unsigned short>(address.port)};
}

[[noreturn]] void FailToReach(const DaemonAddress& address, const std::string& why) {
  throw Error("the flight daemon on port " + std::to_string(address.port) +
              " cannot be reached: " + why);
}

std::string ReasonIn(const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  if (json.is_object() && json.contains("error") && json["error"].is_string()) {
    return json["error"].get<std::string>();
  }
  return "it does not say why";
}

// "data: {…}" of one line of an event stream.
std::optional<Json> EventIn(const std::string& line) {
  constexpr std::string_view kData = "data: ";
  if (!line.starts_with(kData)) return std::nullopt;
  Json json = Json::parse(line.substr(kData.size()), nullptr, false);
  if (json.is_discarded()) return std::nullopt;
  return json;
}

}  // namespace

Json FlightClient::Send(const std::string& method, const std::string& target,
                        const std::string& body) const {
  HttpCall call{kHost, std::to_string(address_.port), method, target, body};
  call.headers.emplace_back("Authorization", "Bearer " + address_.token);
  HttpReply reply;
  try {
    reply = CallHttp(call, {.silence_timeout_s = kPatienceS, .total_timeout_s = kPatienceS});
  } catch (const Error& error) {
    FailToReach(address_, error.what());
  }
  if (reply.status != 200) throw Error("the flight daemon refuses: " + ReasonIn(reply.body));
  Json json = Json::parse(reply.body, nullptr, false);
  if (!json.is_object()) FailToReach(address_, "its answer is no JSON object");
  return json;
}

Json FlightClient::Status() const { return Send("GET", "/v1/status", ""); }
Json FlightClient::Load(const FlightMission& mission) const {
  return Send("POST", "/v1/mission", MissionToJson(mission).dump());
}
Json FlightClient::Append(const Json& changes) const {
  return Send("POST", "/v1/append", changes.dump());
}
Json FlightClient::Preflight() const { return Send("POST", "/v1/preflight", ""); }
Json FlightClient::Start() const { return Send("POST", "/v1/start", ""); }
Json FlightClient::Pause() const { return Send("POST", "/v1/pause", ""); }
Json FlightClient::Resume() const { return Send("POST", "/v1/resume", ""); }
Json FlightClient::Abort(bool land) const {
  return Send("POST", "/v1/abort", land ? R"({"how":"land"})" : R"({"how":"rtl"})");
}

Json FlightClient::Post(const std::string& target, const Json& body) const {
  return Send("POST", target, body.dump());
}

bool FlightClient::Watch(std::size_t since, const std::function<bool(const Json&)>& take,
                         const std::function<bool()>& idle) const {
  asio::io_context io;
  tcp::socket socket(io);
  boost::system::error_code error;
  socket.connect(EndpointOf(address_), error);
  if (error) FailToReach(address_, error.message());
  const std::string target = "/v1/events?since=" + std::to_string(since);
  http::request<http::empty_body> request(http::verb::get, target, 11);
  request.set(http::field::host, std::string(kHost) + ":" + std::to_string(address_.port));
  request.set(http::field::authorization, "Bearer " + address_.token);
  http::write(socket, request, error);
  if (error) FailToReach(address_, error.message());
  asio::streambuf buffer;
  std::istream stream(&buffer);
  while (true) {
    asio::read_until(socket, buffer, '\n', error);
    if (error) return false;
    std::string line;
    std::getline(stream, line);
    if (line.starts_with(": ") && !idle()) return true;
    const std::optional<Json> event = EventIn(line);
    if (event && !take(*event)) return true;
  }
}

}  // namespace colmap_ext
