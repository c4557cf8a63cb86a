#include "flight/api_call.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "colmap_ext/scene/mesh_io.h"

namespace colmap_ext {
namespace {

bool IsOwnHost(std::string_view host) {
  const std::string_view name = host.substr(0, host.rfind(':'));
  return name == "127.0.0.1" || name == "localhost" || host == "127.0.0.1" || host == "localhost";
}

// In a time that does not depend on where they differ.
bool IsSame(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    difference |= static_cast<unsigned>(a[i] ^ b[i]);
  }
  return difference == 0;
}

void CheckCaller(const ApiRequest& request, const std::string& token) {
  if (!request.origin.empty()) throw ApiError(403, "requests of web pages are refused");
  if (!IsOwnHost(request.host)) throw ApiError(403, "Host must be 127.0.0.1 or localhost");
  if (!IsSame(request.authorization, "Bearer " + token)) {
    throw ApiError(401, "the token of flightd.json is needed: Authorization: Bearer …");
  }
}

Json ParseBody(const std::string& body) {
  if (body.empty()) return Json::object();
  // Deep nesting would overflow the stack of a recursive reader.
  const auto too_deep = [](int depth, Json::parse_event_t, Json&) {
    if (depth > 16) throw ApiError(400, "the JSON is nested too deeply");
    return true;
  };
  try {
    Json json = Json::parse(body, too_deep);
    if (!json.is_object()) throw ApiError(400, "the body must be a JSON object");
    return json;
  } catch (const Json::parse_error& error) {
    throw ApiError(400, "the body is no JSON (byte " + std::to_string(error.byte) + ")");
  } catch (const Json::exception&) {
    throw ApiError(400, "the body has a number that is too large");
  }
}

FlightRequest ParseLoad(const Json& json) {
  FlightRequest request;
  request.kind = FlightRequest::Kind::kLoad;
  request.mission = MissionFromJson(json, "request");
  return request;
}

// {"revision", "stops"} and what changes: "surface_path", "transit_z_m", "at_end".
FlightRequest ParseAppend(const Json& json, const FlightMission& present) {
  Json merged = MissionToJson(present);
  for (const char* key : {"revision", "surface_path", "transit_z_m", "at_end", "limits"}) {
    if (json.contains(key)) merged[key] = json[key];
  }
  if (!json.contains("revision")) throw ApiError(400, "request: /revision is missing");
  merged["stops"] = Json::array();
  FlightRequest request;
  request.kind = FlightRequest::Kind::kAppend;
  request.mission = MissionFromJson(merged, "request");
  request.stops = StopsFromJson(JsonNode(json, "request")["stops"]);
  return request;
}

FlightRequest ParseAbort(const Json& json) {
  FlightRequest request;
  request.kind = FlightRequest::Kind::kAbort;
  const std::string how = JsonNode(json, "request")["how"].Text();
  if (how != "rtl" && how != "land") throw ApiError(400, "request: /how must be rtl or land");
  request.land = how == "land";
  return request;
}

FlightRequest Plain(FlightRequest::Kind kind) {
  FlightRequest request;
  request.kind = kind;
  return request;
}

FlightRequest ParseRequest(const std::string& path, const Json& json,
                           const FlightMission& present) {
  using Kind = FlightRequest::Kind;
  if (path == "/v1/mission") return ParseLoad(json);
  if (path == "/v1/append") return ParseAppend(json, present);
  if (path == "/v1/preflight") return Plain(Kind::kPreflight);
  if (path == "/v1/start") return Plain(Kind::kStart);
  if (path == "/v1/pause") return Plain(Kind::kPause);
  if (path == "/v1/resume") return Plain(Kind::kResume);
  return ParseAbort(json);
}

std::size_t ParseSince(std::string_view query) {
  if (query.empty()) return 0;
  std::size_t since = 0;
  constexpr std::string_view kKey = "since=";
  const char* end = query.data() + query.size();
  if (!query.starts_with(kKey)) throw ApiError(400, "the only parameter is since=<number>");
  const auto result = std::from_chars(query.data() + kKey.size(), end, since);
  if (result.ec != std::errc() || result.ptr != end) throw ApiError(400, "since: not a number");
  return since;
}

}  // namespace

ApiCall ParseApiCall(const ApiRequest& request, const std::string& token,
                     const FlightMission& present) {
  CheckCaller(request, token);
  const std::size_t question = request.target.find('?');
  const std::string path = request.target.substr(0, question);
  const std::string query =
      question == std::string::npos ? "" : request.target.substr(question + 1);
  constexpr std::array kPosts = {"/v1/mission", "/v1/append", "/v1/preflight", "/v1/start",
                                 "/v1/pause",   "/v1/resume", "/v1/abort"};
  const bool is_get = path == "/v1/status" || path == "/v1/events";
  const bool is_post = std::find(kPosts.begin(), kPosts.end(), path) != kPosts.end();
  if (!is_get && !is_post) throw ApiError(404, "no such path; docs/flight_api.md lists them");
  if (request.method != (is_get ? "GET" : "POST")) {
    throw ApiError(405, path + " takes " + (is_get ? "GET" : "POST"));
  }
  ApiCall call;
  if (is_get) {
    call.kind = path == "/v1/status" ? ApiCall::Kind::kStatus : ApiCall::Kind::kEvents;
    call.since = ParseSince(query);
    return call;
  }
  if (request.body.size() > kMaxApiBody) throw ApiError(413, "the body is too long");
  call.kind = ApiCall::Kind::kRequest;
  try {
    call.request = ParseRequest(path, ParseBody(request.body), present);
  } catch (const ApiError&) {
    throw;
  } catch (const Error& error) {
    throw ApiError(400, error.what());
  }
  const std::size_t stops = call.request.mission.stops.size() + call.request.stops.size();
  if (stops > kMaxApiStops) throw ApiError(400, "too many stops");
  call.needs_surface = !call.request.mission.surface_path.empty();
  return call;
}

void LoadSurface(FlightRequest* request) {
  const TriangleMesh mesh = ReadMesh(request->mission.surface_path);
  if (mesh.faces.empty()) {
    throw Error(request->mission.surface_path.string() + ": has no faces: no surface to avoid");
  }
  request->surface_top_z_m = BoundsOf(mesh).max().z();
  request->surface = std::make_shared<RayScene>(mesh);
}

}  // namespace colmap_ext
