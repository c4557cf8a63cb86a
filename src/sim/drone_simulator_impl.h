// The inside of DroneSimulator: drone_simulator.cc has time and links, drone_http.cc the HTTP API.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/mavlink/ftp_server.h"
#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/mavlink/lossy_link.h"
#include "colmap_ext/mavlink/signing.h"
#include "colmap_ext/sim/drone_faults.h"
#include "colmap_ext/sim/drone_simulator.h"
#include "colmap_ext/sim/picture_store.h"
#include "colmap_ext/util/http_server.h"

namespace colmap_ext {

struct DroneSimulator::Impl : std::enable_shared_from_this<DroneSimulator::Impl> {
  Impl(boost::asio::io_context* io, const DroneSimulatorOptions& options, const GeoPosition& origin,
       const Eigen::Vector3d& home, const DroneSite& site, std::function<void()> crash,
       const JobControl& job);

  // drone_simulator.cc
  void Open(const SimulatedCamera& camera);
  void Start();
  void Stop();
  void Schedule();
  void Advance();
  void Slice();
  void WatchClearance();
  void EnableSigning(const MavSigningKey& key);
  void SendFrame(const MavFrame& frame);
  void ReceivePacket(std::span<const std::uint8_t> packet);
  void ReceiveFrame(const MavFrame& frame);
  void ReceiveFtp(const MavFileTransferProtocol& message, const MavFrame& frame);
  void Change(const std::string& faults_json);
  Json Status() const;

  // drone_http.cc
  void Answer(const HttpRequest& request, HttpServer::Respond respond);
  void AnswerPicture(const std::string& path, HttpServer::Respond respond);
  void SendPicture(const std::string& name, PhotoResolution resolution,
                   const HttpServer::Respond& respond) const;
  void PictureDone(const std::string& name, PhotoResolution resolution);
  Json PictureList() const;

  boost::asio::io_context* io;
  DroneSimulatorOptions options;
  GeoPosition origin;
  Eigen::Vector3d home;
  const DroneSite& site;
  std::function<void()> crash;
  JobControl job;

  SimulatedAutopilot drone;
  DroneFaults faults;
  LossyLink uplink, downlink;  // to the drone, from the drone
  MavParser parser;
  std::optional<MavSigning> signing;
  std::optional<MavLink> link;
  std::optional<HttpServer> http;
  std::optional<PictureStore> pictures;
  std::optional<MavFtpServer> ftp;
  // Who waits for a picture, by name and resolution.
  std::multimap<std::pair<std::string, PhotoResolution>, HttpServer::Respond> waiting;

  boost::asio::steady_timer timer;
  std::chrono::steady_clock::time_point started_at;
  bool is_running = false;
  double time_s = 0;  // simulated
  double next_clearance_s = 0, clearance_m = 0, min_clearance_m = 0;
};

}  // namespace colmap_ext
