#include "colmap_ext/mavlink/ftp_client.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr int kLongestBackoff = 5;  // doublings
constexpr int kBurstPatience = 4;   // timeouts without a packet before a burst counts as over
constexpr std::uint16_t kSequenceJump = 1024;

std::uint32_t LoadSize(const MavFtpPayload& payload) {
  std::uint32_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) size |= static_cast<std::uint32_t>(payload.data[i]) << 8U * i;
  return size;
}

}  // namespace

std::string MavFtpClientOptions::Check() const {
  if (!(timeout_s >= 0.001 && timeout_s <= 60)) return "FTP: timeout_s is not in 0.001 … 60";
  if (retries < 0 || retries > 100) return "FTP: retries is not in 0 … 100";
  if (max_reads < 1 || max_reads > 64) return "FTP: max_reads is not in 1 … 64";
  if (max_file_bytes == 0) return "FTP: max_file_bytes is 0";
  return "";
}

MavFtpClient::MavFtpClient(const MavFtpClientOptions& options, std::uint16_t first_sequence)
    : options_(options), next_sequence_(first_sequence) {
  ThrowIfInvalid(options.Check());
}

void MavFtpClient::Begin(MavFtpOpcode opcode, const std::string& path, double now_s) {
  if (status_ == MavFtpStatus::kRunning)
    throw Error("FTP: a transfer of " + path_ + " runs already");
  if (path.empty() || path.size() > kMavFtpMaxData) {
    throw Error("FTP: a path has 1 … 239 bytes, '" + path + "' has " + std::to_string(path.size()));
  }
  status_ = MavFtpStatus::kRunning;
  path_ = path;
  failure_.clear();
  session_.reset();
  has_reset_ = false;
  data_.clear();
  gaps_.clear();
  burst_end_ = 0;
  entries_.clear();
  entries_seen_ = 0;
  requests_.clear();
  // Far from what may still be under way of the last task: sessions have the same numbers again.
  next_sequence_ = static_cast<std::uint16_t>(next_sequence_ + kSequenceJump);
  first_sequence_ = next_sequence_;
  PostPath(opcode, 0, now_s);
}

void MavFtpClient::PostPath(MavFtpOpcode opcode, std::uint32_t offset, double now_s) {
  MavFtpPayload payload = NewPayload(opcode);
  payload.data.assign(path_.begin(), path_.end());
  payload.size = static_cast<std::uint8_t>(path_.size());
  payload.offset = offset;
  Post(payload, now_s);
}

void MavFtpClient::Download(const std::string& path, double now_s) {
  Begin(MavFtpOpcode::kOpenFileRo, path, now_s);
}

void MavFtpClient::List(const std::string& folder, double now_s) {
  Begin(MavFtpOpcode::kListDirectory, folder, now_s);
}

void MavFtpClient::Abort(const std::string& reason, double now_s) {
  if (status_ == MavFtpStatus::kRunning) Finish(MavFtpStatus::kFailed, reason, now_s);
}

// An answer has the number of its request plus one, so ours go up by two.
MavFtpPayload MavFtpClient::NewPayload(MavFtpOpcode opcode) {
  MavFtpPayload payload;
  payload.sequence = next_sequence_;
  next_sequence_ = static_cast<std::uint16_t>(next_sequence_ + 2);
  payload.opcode = opcode;
  payload.session = session_.value_or(0);
  return payload;
}

double MavFtpClient::WaitS(int tries) const {
  return std::ldexp(options_.timeout_s, std::min(tries, kLongestBackoff));
}

void MavFtpClient::Post(const MavFtpPayload& payload, double now_s) {
  requests_.push_back({payload, now_s + WaitS(0), 0, false});
  outgoing_.push_back(payload);
}

std::vector<MavFtpPayload> MavFtpClient::TakeOutgoing() { return std::exchange(outgoing_, {}); }

std::uint32_t MavFtpClient::BytesMissing() const {
  std::uint32_t missing = 0;
  for (const auto& [begin, end] : gaps_) missing += end - begin;
  return missing;
}

std::optional<double> MavFtpClient::NextTimeS() const {
  if (requests_.empty()) return std::nullopt;
  return std::ranges::min(requests_, {}, &Request::due_s).due_s;
}

// A read is known by its place too, since servers differ in how they number pipelined answers.
MavFtpClient::Request* MavFtpClient::FindRequest(const MavFtpPayload& answer) {
  const auto fits = [&](const Request& request) {
    const MavFtpPayload& asked = request.payload;
    if (asked.opcode != answer.request_opcode) return false;
    switch (asked.opcode) {
      case MavFtpOpcode::kBurstReadFile:
        return asked.session == answer.session;
      case MavFtpOpcode::kReadFile:
        return asked.session == answer.session && asked.offset == answer.offset;
      default:
        return answer.sequence == static_cast<std::uint16_t>(asked.sequence + 1);
    }
  };
  const auto found = std::ranges::find_if(requests_, fits);
  return found == requests_.end() ? nullptr : &*found;
}

void MavFtpClient::Forget(const Request* request) {
  requests_.erase(requests_.begin() + (request - requests_.data()));
}

void MavFtpClient::Receive(const MavFtpPayload& payload, double now_s) {
  const auto age = static_cast<std::uint16_t>(payload.sequence - first_sequence_);
  if (age >= 0x8000) return;  // of an earlier task
  const auto next = static_cast<std::uint16_t>(payload.sequence + 1);
  if (static_cast<std::uint16_t>(next - next_sequence_) < 0x8000) next_sequence_ = next;
  Request* const request = FindRequest(payload);
  if (request != nullptr) {
    // The server lives: only silence ends a transfer, not bad luck of one request among many.
    for (Request& other : requests_) other.tries = 0;
  }
  if (request != nullptr && payload.opcode == MavFtpOpcode::kAck) {
    ReceiveAck(request, payload, now_s);
  } else if (request != nullptr && payload.opcode == MavFtpOpcode::kNak) {
    const Request answered = *request;
    Forget(request);
    ReceiveNak(answered, payload, now_s);
  } else if (payload.opcode == MavFtpOpcode::kAck && payload.session == session_ &&
             payload.request_opcode == MavFtpOpcode::kBurstReadFile) {
    // A straggler of a burst that counts as over.
    if (TakeData(payload) && gaps_.empty()) RequestMissing(now_s);
  }
}

void MavFtpClient::ReceiveAck(Request* request, const MavFtpPayload& payload, double now_s) {
  const MavFtpPayload asked = request->payload;
  if (asked.opcode == MavFtpOpcode::kBurstReadFile) {
    if (TakeData(payload)) burst_end_ = std::max(burst_end_, payload.offset + payload.size);
    request->had_answer = true;
    request->due_s = now_s + kBurstPatience * WaitS(0);
    if (payload.burst_complete || gaps_.empty()) {
      Forget(request);
      RequestMissing(now_s);
    }
    return;
  }
  Forget(request);
  switch (asked.opcode) {
    case MavFtpOpcode::kOpenFileRo:
      Opened(payload, now_s);
      break;
    case MavFtpOpcode::kListDirectory:
      TakeEntries(payload, now_s);
      break;
    case MavFtpOpcode::kResetSessions:
      PostPath(MavFtpOpcode::kOpenFileRo, 0, now_s);
      break;
    case MavFtpOpcode::kReadFile:
      if (payload.size == 0) {
        Finish(MavFtpStatus::kFailed, "the server sends no data", now_s);
      } else {
        TakeData(payload);
        RequestMissing(now_s);
      }
      break;
    default:
      break;  // terminated
  }
}

void MavFtpClient::ReceiveNak(const Request& request, const MavFtpPayload& payload, double now_s) {
  const MavFtpError error = payload.Error();
  switch (request.payload.opcode) {
    case MavFtpOpcode::kTerminateSession:
      return;
    case MavFtpOpcode::kBurstReadFile:
      if (error != MavFtpError::kEndOfFile) break;
      burst_end_ = static_cast<std::uint32_t>(data_.size());
      RequestMissing(now_s);
      return;
    case MavFtpOpcode::kListDirectory:
      if (error != MavFtpError::kEndOfFile) break;
      Finish(MavFtpStatus::kDone, "", now_s);
      return;
    case MavFtpOpcode::kReadFile:
      if (error != MavFtpError::kEndOfFile) break;
      Finish(MavFtpStatus::kFailed,
             "the file ended at byte " + std::to_string(request.payload.offset) + " of " +
                 std::to_string(data_.size()),
             now_s);
      return;
    default:
      break;
  }
  // A client that died left its sessions open.
  if (error == MavFtpError::kNoSessionsAvailable && !has_reset_ &&
      request.payload.opcode == MavFtpOpcode::kOpenFileRo) {
    has_reset_ = true;
    Post(NewPayload(MavFtpOpcode::kResetSessions), now_s);
    return;
  }
  Finish(MavFtpStatus::kFailed, "the server says: " + MavFtpErrorText(error), now_s);
}

void MavFtpClient::Opened(const MavFtpPayload& payload, double now_s) {
  session_ = payload.session;
  if (payload.size < 4) {
    Finish(MavFtpStatus::kFailed, "the server does not say how long the file is", now_s);
    return;
  }
  const std::uint32_t size = LoadSize(payload);
  if (size > options_.max_file_bytes) {
    Finish(MavFtpStatus::kFailed,
           "the file has " + std::to_string(size) + " bytes, allowed are " +
               std::to_string(options_.max_file_bytes),
           now_s);
    return;
  }
  data_.assign(size, 0);
  if (size > 0) gaps_[0] = size;
  RequestMissing(now_s);
}

// Entries end in NUL: F, D or S (skipped), name, and for a file a tab and its size.
void MavFtpClient::TakeEntries(const MavFtpPayload& payload, double now_s) {
  std::string_view text = payload.Text();
  std::uint32_t seen = 0;
  while (!text.empty()) {
    const std::string_view entry = text.substr(0, text.find('\0'));
    text.remove_prefix(std::min(text.size(), entry.size() + 1));
    if (entry.empty()) continue;
    ++seen;
    const std::string_view name = entry.substr(1, entry.find('\t') - 1);
    if (entry[0] == 'D') entries_.push_back({std::string(name), true, 0});
    if (entry[0] != 'F') continue;
    std::uint64_t bytes = 0;
    for (const char digit : entry.substr(std::min(entry.size(), name.size() + 2))) {
      if (digit < '0' || digit > '9') break;
      bytes = 10 * bytes + static_cast<std::uint64_t>(digit - '0');
    }
    entries_.push_back({std::string(name), false, bytes});
  }
  if (seen == 0) {
    Finish(MavFtpStatus::kDone, "", now_s);
    return;
  }
  entries_seen_ += seen;
  PostPath(MavFtpOpcode::kListDirectory, entries_seen_, now_s);
}

// Whether the piece lies in the file. What came before is left as it is.
bool MavFtpClient::TakeData(const MavFtpPayload& payload) {
  const std::uint64_t begin = payload.offset;
  const std::uint64_t end = begin + payload.data.size();
  if (payload.data.empty() || end > data_.size()) return false;
  auto gap = gaps_.upper_bound(static_cast<std::uint32_t>(begin));
  if (gap != gaps_.begin()) --gap;
  while (gap != gaps_.end() && gap->first < end) {
    const auto [gap_begin, gap_end] = *gap;
    const std::uint32_t from = std::max(gap_begin, payload.offset);
    const std::uint32_t to = std::min(gap_end, static_cast<std::uint32_t>(end));
    if (from >= to) {
      ++gap;
      continue;
    }
    std::copy(payload.data.begin() + (from - payload.offset),
              payload.data.begin() + (to - payload.offset), data_.begin() + from);
    gap = gaps_.erase(gap);
    if (gap_begin < from) gaps_.emplace(gap_begin, from);
    if (to < gap_end) gaps_.emplace(to, gap_end);
  }
  return true;
}

void MavFtpClient::RequestMissing(double now_s) {
  if (gaps_.empty()) {
    Finish(MavFtpStatus::kDone, "", now_s);
    return;
  }
  if (burst_end_ < data_.size()) {
    MavFtpPayload burst = NewPayload(MavFtpOpcode::kBurstReadFile);
    burst.offset = burst_end_;
    burst.size = kMavFtpMaxData;
    Post(burst, now_s);
    return;
  }
  auto free = options_.max_reads - static_cast<int>(requests_.size());
  for (const auto& [begin, end] : gaps_) {
    for (std::uint32_t at = begin; at < end && free > 0;) {
      const auto size = static_cast<std::uint8_t>(std::min<std::size_t>(end - at, kMavFtpMaxData));
      const bool is_under_way = std::ranges::any_of(
          requests_, [&](const Request& request) { return request.payload.offset == at; });
      if (!is_under_way) {
        MavFtpPayload read = NewPayload(MavFtpOpcode::kReadFile);
        read.offset = at;
        read.size = size;
        Post(read, now_s);
        --free;
      }
      at += size;
    }
    if (free <= 0) return;
  }
}

void MavFtpClient::Finish(MavFtpStatus status, const std::string& failure, double now_s) {
  status_ = status;
  if (status == MavFtpStatus::kFailed) failure_ = "FTP of " + path_ + ": " + failure;
  requests_.clear();
  if (!session_) return;
  Post(NewPayload(MavFtpOpcode::kTerminateSession), now_s);
  session_.reset();
}

void MavFtpClient::Poll(double now_s) {
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    Request& request = requests_[i];
    if (now_s < request.due_s) continue;
    if (request.payload.opcode == MavFtpOpcode::kBurstReadFile && request.had_answer) {
      Forget(&request);  // its end was lost
      RequestMissing(now_s);
      return;
    }
    if (request.tries >= options_.retries) {
      if (request.payload.opcode == MavFtpOpcode::kTerminateSession) {
        Forget(&request);
      } else {
        Finish(MavFtpStatus::kFailed,
               "no answer to " + std::to_string(request.tries + 1) + " requests", now_s);
      }
      return;
    }
    ++request.tries;
    ++repetitions_;
    request.due_s = now_s + WaitS(request.tries);
    outgoing_.push_back(request.payload);
  }
}

}  // namespace colmap_ext
