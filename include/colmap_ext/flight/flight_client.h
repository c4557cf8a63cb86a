// Talks to the daemon of a workspace (docs/flight_api.md). For the session and for flight_client.
#pragma once

#include <functional>
#include <string>

#include "colmap_ext/flight/flight_mission.h"
#include "colmap_ext/scene/daemon_address.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

// Every method throws Error when the daemon cannot be reached, or with its reason when it refuses.
class FlightClient {
 public:
  explicit FlightClient(DaemonAddress address) : address_(std::move(address)) {}

  Json Status() const;
  Json Load(const FlightMission& mission) const;
  // `changes`: {"revision", "stops", and what else changes}.
  Json Append(const Json& changes) const;
  Json Preflight() const;
  Json Start() const;
  Json Pause() const;
  Json Resume() const;
  Json Abort(bool land) const;
  // Any other request with a JSON object as answer.
  Json Post(const std::string& target, const Json& body) const;
  // Calls `take` with every event from number `since` on, in order, until it returns false or the
  // daemon ends (then false). `idle`: called about every 10 s without news; false ends, too.
  bool Watch(std::size_t since, const std::function<bool(const Json&)>& take,
             const std::function<bool()>& idle) const;

 private:
  Json Send(const std::string& method, const std::string& target, const std::string& body) const;

  DaemonAddress address_;
};

}  // namespace colmap_ext
