// Fetches files by MAVLink FTP: open, burst read, gaps read again, terminate. Without input, output
// and clock: payloads go out by TakeOutgoing and come in by Receive, time comes by argument.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/ftp_payload.h"

namespace colmap_ext {

struct MavFtpClientOptions {
  double timeout_s = 0.05;  // before the first repetition; doubles up to 1.6 s; mavlink.io
  int retries = 6;          // of one request while no other is answered, mavlink.io
  int max_reads = 4;        // requests for gaps that are under way together
  std::uint32_t max_file_bytes = 512U << 20U;
  std::string Check() const;
};

enum class MavFtpStatus { kIdle, kRunning, kDone, kFailed };

struct MavFtpEntry {
  std::string name;
  bool is_folder = false;
  std::uint64_t bytes = 0;  // of a file
  bool operator==(const MavFtpEntry&) const = default;
};

class MavFtpClient {
 public:
  // `first_sequence`: anything but what the last client of this program began with, so that answers
  // to that one are not taken for ours.
  explicit MavFtpClient(const MavFtpClientOptions& options, std::uint16_t first_sequence = 0);

  // Start one task; throw Error while another runs, or when the path is too long to be sent.
  void Download(const std::string& path, double now_s);
  void List(const std::string& folder, double now_s);
  // Fails the task, and closes its file on the server.
  void Abort(const std::string& reason, double now_s);

  // What the server sent us (the caller knows by the frame that it was the server).
  void Receive(const MavFtpPayload& payload, double now_s);
  // Repeats what has had no answer. Call when NextTimeS() has come.
  void Poll(double now_s);
  std::optional<double> NextTimeS() const;
  // What is to be sent now, in order.
  std::vector<MavFtpPayload> TakeOutgoing();

  MavFtpStatus Status() const { return status_; }
  const std::string& Failure() const { return failure_; }  // one line, when kFailed
  // The file, whole when kDone.
  const std::vector<std::uint8_t>& Data() const { return data_; }
  std::uint32_t BytesMissing() const;
  const std::vector<MavFtpEntry>& Entries() const { return entries_; }  // of List, when kDone
  std::uint64_t Repetitions() const { return repetitions_; }            // requests sent again

 private:
  struct Request {
    MavFtpPayload payload;
    double due_s = 0;         // for the next repetition
    int tries = 0;            // repetitions so far
    bool had_answer = false;  // bursts
  };

  void Begin(MavFtpOpcode opcode, const std::string& path, double now_s);
  void PostPath(MavFtpOpcode opcode, std::uint32_t offset, double now_s);
  MavFtpPayload NewPayload(MavFtpOpcode opcode);
  void Post(const MavFtpPayload& payload, double now_s);
  double WaitS(int tries) const;
  void ReceiveAck(Request* request, const MavFtpPayload& payload, double now_s);
  void ReceiveNak(const Request& request, const MavFtpPayload& payload, double now_s);
  void Opened(const MavFtpPayload& payload, double now_s);
  void TakeEntries(const MavFtpPayload& payload, double now_s);
  bool TakeData(const MavFtpPayload& payload);
  void RequestMissing(double now_s);
  void Finish(MavFtpStatus status, const std::string& failure, double now_s);
  Request* FindRequest(const MavFtpPayload& answer);
  void Forget(const Request* request);

  MavFtpClientOptions options_;
  std::uint16_t next_sequence_;
  std::uint16_t first_sequence_ = 0;  // of this task
  MavFtpStatus status_ = MavFtpStatus::kIdle;
  std::string path_;
  std::string failure_;
  std::optional<std::uint8_t> session_;
  bool has_reset_ = false;
  std::vector<std::uint8_t> data_;
  std::map<std::uint32_t, std::uint32_t> gaps_;  // begin to end of what is missing
  std::uint32_t burst_end_ = 0;                  // bursts have reached this far
  std::vector<MavFtpEntry> entries_;
  std::uint32_t entries_seen_ = 0;
  std::vector<Request> requests_;  // under way
  std::vector<MavFtpPayload> outgoing_;
  std::uint64_t repetitions_ = 0;
};

}  // namespace colmap_ext
