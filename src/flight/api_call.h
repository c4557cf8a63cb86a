// What an HTTP request asks of the daemon. Pure, so that it can be fuzzed.
#pragma once

#include <string>

#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {

struct ApiRequest {
  std::string method;         // "GET"
  std::string target;         // "/v1/status"
  std::string host;           // header, empty: none
  std::string origin;         // header, empty: none
  std::string authorization;  // header
  std::string body;
};

struct ApiCall {
  enum class Kind { kStatus, kEvents, kRequest };
  Kind kind = Kind::kStatus;
  std::size_t since = 0;  // kEvents: the first event wanted
  FlightRequest request;  // kRequest; its surface is not loaded yet
  bool needs_surface = false;
};

// Refusal of a request, with its HTTP status.
class ApiError : public Error {
 public:
  ApiError(int status, const std::string& reason) : Error(reason), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

inline constexpr std::size_t kMaxApiBody = std::size_t{4} << 20;  // bytes
inline constexpr std::size_t kMaxApiStops = 20000;

// Throws ApiError: 401 without the right token, 403 for requests that a web page may have caused
// (another Host than this one, any Origin), 404, 405, and 400 with the reason for a bad body.
// `present`: the mission that an append goes on with.
ApiCall ParseApiCall(const ApiRequest& request, const std::string& token,
                     const FlightMission& present);

// Reads request.mission.surface_path into request.surface. Throws Error. Takes up to a second.
void LoadSurface(FlightRequest* request);

}  // namespace colmap_ext
