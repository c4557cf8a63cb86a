// HTTP on 127.0.0.1 for the planner and for people (docs/flight_api.md).
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <memory>
#include <string>

#include "colmap_ext/flight/mission_machine.h"

namespace colmap_ext {

// What the server needs of the daemon. Called in the thread that runs the io_context.
struct ApiBackend {
  std::function<Json()> status;
  std::function<FlightReply(const FlightRequest&)> request;
  std::function<const FlightMission&()> mission;
};

class ApiServer {
 public:
  // Listens on 127.0.0.1:`port` (0: any free one). `workers` read surfaces. Throws Error when the
  // port cannot be had.
  ApiServer(boost::asio::io_context* io, boost::asio::thread_pool* workers, int port,
            std::string token, ApiBackend backend);
  ~ApiServer();
  ApiServer(const ApiServer&) = delete;
  ApiServer& operator=(const ApiServer&) = delete;

  int port() const;
  // To everybody who listens to /v1/events, now and later; numbered from 0 on.
  void Publish(const Json& event);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace colmap_ext
