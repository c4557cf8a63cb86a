// Pictures on their way from the camera to the workspace: low resolution first, in workers.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_daemon.h"
#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

class FetchQueue {
 public:
  // Called in the thread of the event loop, once for every request.
  struct Events {
    std::function<void(const FetchRequest& request, const std::string& sha256)> stored;
    std::function<void(const FetchRequest& request, const std::string& reason)> failed;
  };

  FetchQueue(boost::asio::io_context* io, boost::asio::thread_pool* workers,
             const DaemonOptions& options, Events events);
  ~FetchQueue();
  FetchQueue(const FetchQueue&) = delete;
  FetchQueue& operator=(const FetchQueue&) = delete;

  // For the datum of what is added from now on.
  void SetMission(const FlightMission& mission);
  void Add(FetchRequest request);
  // MAVLink FTP, for pictures whose URL begins with mftp:. Every FILE_TRANSFER_PROTOCOL that came,
  // and what is to be sent to `vehicle_system`, when packets came and ten times a second; while the
  // vehicle is not heard, nothing is sent and nothing fails.
  void Receive(const MavFrame& frame, double now_s);
  std::vector<MavFileTransferProtocol> PollFtp(int vehicle_system, bool is_heard, double now_s);
  void Stop();  // no event comes any more
  std::size_t size() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace colmap_ext
