#include "colmap_ext/flight/flight_client.h"

#include <signal.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <fstream>
#include <istream>
#include <string_view>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr const char* kHost = "127.0.0.1";

tcp::endpoint EndpointOf(const DaemonAddress& address) {
  return {asio::ip::address_v4::loopback(), static_cast<unsigned short>(address.port)};
}

http::request<http::string_body> MakeRequest(const DaemonAddress& address,
                                             const std::string& method, const std::string& target,
                                             const std::string& body) {
  http::request<http::string_body> request(http::string_to_verb(method), target, 11);
  request.set(http::field::host, std::string(kHost) + ":" + std::to_string(address.port));
  request.set(http::field::authorization, "Bearer " + address.token);
  request.set(http::field::content_type, "application/json");
  request.keep_alive(false);
  request.body() = body;
  request.prepare_payload();
  return request;
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

std::filesystem::path DaemonAddressPath(const std::filesystem::path& workspace_path) {
  return workspace_path / "flightd.json";
}

std::optional<DaemonAddress> FindDaemon(const std::filesystem::path& workspace_path) {
  const std::filesystem::path path = DaemonAddressPath(workspace_path);
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  const DaemonAddress address{root["port"].Integer(), root["pid"].Integer(), root["token"].Text()};
  if (address.pid <= 0 || kill(address.pid, 0) != 0) return std::nullopt;
  return address;
}

void WriteDaemonAddress(const DaemonAddress& address, const std::filesystem::path& workspace_path) {
  const std::filesystem::path path = DaemonAddressPath(workspace_path);
  const std::filesystem::path temporary = TemporaryPathFor(path);
  WriteFileAtomically(temporary, "");
  std::filesystem::permissions(
      temporary, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  std::ofstream stream(temporary);
  stream << Json({{"port", address.port}, {"pid", address.pid}, {"token", address.token}}).dump()
         << '\n';
  stream.close();
  if (!stream) throw Error(path.string() + ": cannot be written");
  CommitTemporaryFile(temporary, path);
}

Json FlightClient::Send(const std::string& method, const std::string& target,
                        const std::string& body) const {
  asio::io_context io;
  beast::tcp_stream stream(io);
  boost::system::error_code error;
  stream.connect(EndpointOf(address_), error);
  if (error) FailToReach(address_, error.message());
  http::write(stream, MakeRequest(address_, method, target, body), error);
  if (error) FailToReach(address_, error.message());
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(std::uint64_t{64} << 20);
  http::read(stream, buffer, parser, error);
  if (error) FailToReach(address_, error.message());
  const http::response<http::string_body>& response = parser.get();
  if (response.result() != http::status::ok) {
    throw Error("the flight daemon refuses: " + ReasonIn(response.body()));
  }
  Json json = Json::parse(response.body(), nullptr, false);
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
  http::write(socket, MakeRequest(address_, "GET", target, ""), error);
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
