// Serves one folder by MAVLink FTP, to be read only. Without input, output and clock of the link;
// it reads the folder's files.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/frame.h"
#include "colmap_ext/mavlink/ftp_payload.h"

namespace colmap_ext {

struct MavFtpServerOptions {
  int max_sessions = 4;
  double session_lifetime_s = 10;  // an idle session gives way to a new one after this
  int burst_packets = 500;         // at most in one burst
  double packets_per_s = 2000;     // of bursts: about 0.5 MB/s
  std::string Check() const;
};

class MavFtpServer {
 public:
  // `folder` is what clients see as "/". Nothing outside it is ever served: paths with "..", links
  // that lead out of it and special files are "not found".
  MavFtpServer(const std::filesystem::path& folder, const MavFtpServerOptions& options);

  // Answers to one request that `from` carried. A request that came before, by its number, gets the
  // same answer again.
  std::vector<MavFileTransferProtocol> Receive(const MavFileTransferProtocol& message,
                                               const MavFrame& from, double now_s);
  // Packets of bursts that are due.
  std::vector<MavFileTransferProtocol> Poll(double now_s);
  std::optional<double> NextTimeS() const;
  std::size_t OpenSessions() const { return sessions_.size(); }

 private:
  using Client = std::pair<std::uint8_t, std::uint8_t>;  // system, component
  struct Burst {
    std::uint16_t sequence = 0;  // of the next packet
    std::uint32_t offset = 0;
    std::uint8_t chunk = 0;  // bytes
    int packets_left = 0;
    double due_s = 0;
  };
  struct Session {
    Client client;
    std::ifstream file;
    std::uint32_t bytes = 0;
    double used_s = 0;
    std::optional<Burst> burst;
  };

  struct Answered {
    MavFtpPayload request;
    MavFtpPayload reply;
    double time_s = 0;
  };

  MavFtpPayload Answer(const MavFtpPayload& request, const Client& client, double now_s);
  MavFtpPayload Open(const MavFtpPayload& request, const Client& client, double now_s);
  MavFtpPayload Read(const MavFtpPayload& request, Session* session);
  MavFtpPayload List(const MavFtpPayload& request) const;
  MavFtpPayload NextOfBurst(std::uint8_t id, Session* session);
  Session* Find(const MavFtpPayload& request, const Client& client, double now_s);
  std::optional<std::filesystem::path> Resolve(const MavFtpPayload& request) const;

  std::filesystem::path folder_;
  MavFtpServerOptions options_;
  std::map<std::uint8_t, std::unique_ptr<Session>> sessions_;
  std::map<Client, std::deque<Answered>> answered_;  // the last ones of each client
};

}  // namespace colmap_ext
