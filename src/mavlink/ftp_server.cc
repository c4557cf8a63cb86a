#include "colmap_ext/mavlink/ftp_server.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <system_error>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRememberedAnswers = 16;
constexpr std::size_t kRememberedClients = 32;
constexpr double kRememberS = 5;
constexpr int kMostPacketsAPoll = 256;

MavFtpPayload Reply(const MavFtpPayload& request, MavFtpOpcode opcode) {
  MavFtpPayload reply;
  reply.sequence = static_cast<std::uint16_t>(request.sequence + 1);
  reply.session = request.session;
  reply.opcode = opcode;
  reply.request_opcode = request.opcode;
  reply.offset = request.offset;
  return reply;
}

MavFtpPayload Ack(const MavFtpPayload& request, std::vector<std::uint8_t> data = {}) {
  MavFtpPayload reply = Reply(request, MavFtpOpcode::kAck);
  reply.size = static_cast<std::uint8_t>(data.size());
  reply.data = std::move(data);
  return reply;
}

MavFtpPayload Nak(const MavFtpPayload& request, MavFtpError error) {
  MavFtpPayload reply = Reply(request, MavFtpOpcode::kNak);
  reply.data = {static_cast<std::uint8_t>(error)};
  reply.size = 1;
  return reply;
}

std::vector<std::uint8_t> ReadAt(std::ifstream* file, std::uint32_t offset, std::size_t count) {
  std::vector<std::uint8_t> data(count);
  file->clear();
  file->seekg(offset);
  file->read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(count));
  data.resize(static_cast<std::size_t>(std::max<std::streamsize>(file->gcount(), 0)));
  return data;
}

}  // namespace

std::string MavFtpServerOptions::Check() const {
  if (max_sessions < 1 || max_sessions > 255) return "FTP: max_sessions is not in 1 … 255";
  if (!(session_lifetime_s >= 0)) return "FTP: session_lifetime_s is negative";
  if (burst_packets < 1) return "FTP: burst_packets is below 1";
  if (!(packets_per_s >= 1)) return "FTP: packets_per_s is below 1";
  return "";
}

MavFtpServer::MavFtpServer(const fs::path& folder, const MavFtpServerOptions& options)
    : options_(options) {
  ThrowIfInvalid(options.Check());
  RequireFolder(folder, "FTP folder");
  folder_ = fs::canonical(folder);
}

std::optional<fs::path> MavFtpServer::Resolve(const MavFtpPayload& request) const {
  std::string_view text = request.Text();
  text = text.substr(0, text.find('\0'));  // some clients count the NUL
  while (text.starts_with('/')) text.remove_prefix(1);
  std::error_code error;
  const fs::path path = fs::canonical(folder_ / fs::path(text), error);
  if (error) return std::nullopt;
  const auto [end, unused] = std::ranges::mismatch(folder_, path);
  if (end != folder_.end()) return std::nullopt;
  return path;
}

MavFtpPayload MavFtpServer::Open(const MavFtpPayload& request, const Client& client, double now_s) {
  std::error_code error;
  const std::optional<fs::path> path = Resolve(request);
  if (!path || !fs::is_regular_file(*path, error)) {
    return Nak(request, MavFtpError::kFileNotFound);
  }
  const std::uintmax_t bytes = fs::file_size(*path, error);
  if (error || bytes > std::numeric_limits<std::uint32_t>::max()) {
    return Nak(request, MavFtpError::kFail);
  }
  std::erase_if(sessions_, [&](const auto& entry) {
    return now_s - entry.second->used_s > options_.session_lifetime_s;
  });
  std::uint8_t id = 0;
  while (sessions_.contains(id)) ++id;
  if (id >= options_.max_sessions) return Nak(request, MavFtpError::kNoSessionsAvailable);
  auto session = std::make_unique<Session>();
  session->file.open(*path, std::ios::binary);
  if (!session->file) return Nak(request, MavFtpError::kFileProtected);
  session->client = client;
  session->bytes = static_cast<std::uint32_t>(bytes);
  session->used_s = now_s;
  sessions_[id] = std::move(session);
  std::vector<std::uint8_t> size(4);
  for (std::size_t i = 0; i < 4; ++i) size[i] = static_cast<std::uint8_t>(bytes >> (8U * i));
  MavFtpPayload reply = Ack(request, size);
  reply.session = id;
  return reply;
}

MavFtpPayload MavFtpServer::Read(const MavFtpPayload& request, Session* session) {
  if (request.size == 0) return Nak(request, MavFtpError::kInvalidDataSize);
  std::vector<std::uint8_t> data = ReadAt(&session->file, request.offset, request.size);
  if (data.empty()) return Nak(request, MavFtpError::kEndOfFile);
  return Ack(request, std::move(data));
}

MavFtpPayload MavFtpServer::List(const MavFtpPayload& request) const {
  std::error_code error;
  const std::optional<fs::path> path = Resolve(request);
  if (!path || !fs::is_directory(*path, error)) return Nak(request, MavFtpError::kFileNotFound);
  std::vector<std::string> entries;
  for (const auto& entry : fs::directory_iterator(*path, error)) {
    const std::string name = entry.path().filename();
    if (entry.is_directory(error)) {
      entries.push_back("D" + name);
    } else if (entry.is_regular_file(error)) {
      entries.push_back("F" + name + "\t" + std::to_string(entry.file_size(error)));
    }
  }
  std::ranges::sort(entries);
  std::vector<std::uint8_t> data;
  for (std::size_t i = request.offset; i < entries.size(); ++i) {
    // A name that does not fit stays in the numbering, as "skipped".
    if (entries[i].size() + 1 > kMavFtpMaxData) entries[i] = "S";
    if (data.size() + entries[i].size() + 1 > kMavFtpMaxData) break;
    data.insert(data.end(), entries[i].begin(), entries[i].end());
    data.push_back(0);
  }
  if (data.empty()) return Nak(request, MavFtpError::kEndOfFile);
  return Ack(request, std::move(data));
}

MavFtpServer::Session* MavFtpServer::Find(const MavFtpPayload& request, const Client& client,
                                          double now_s) {
  const auto found = sessions_.find(request.session);
  if (found == sessions_.end() || found->second->client != client) return nullptr;
  found->second->used_s = now_s;
  return found->second.get();
}

MavFtpPayload MavFtpServer::Answer(const MavFtpPayload& request, const Client& client,
                                   double now_s) {
  switch (request.opcode) {
    case MavFtpOpcode::kNone:
      return Ack(request);
    case MavFtpOpcode::kOpenFileRo:
      return Open(request, client, now_s);
    case MavFtpOpcode::kListDirectory:
      return List(request);
    case MavFtpOpcode::kResetSessions:
      std::erase_if(sessions_, [&](const auto& entry) { return entry.second->client == client; });
      return Ack(request);
    case MavFtpOpcode::kTerminateSession:
      if (Find(request, client, now_s) == nullptr) break;
      sessions_.erase(request.session);
      return Ack(request);
    case MavFtpOpcode::kReadFile: {
      Session* const session = Find(request, client, now_s);
      if (session == nullptr) break;
      return Read(request, session);
    }
    default:
      return Nak(request, MavFtpError::kUnknownCommand);
  }
  return Nak(request, MavFtpError::kInvalidSession);
}

std::vector<MavFileTransferProtocol> MavFtpServer::Receive(const MavFileTransferProtocol& message,
                                                           const MavFrame& from, double now_s) {
  const std::optional<MavFtpPayload> request = DecodeMavFtp(message);
  // Answers to others pass here too, when systems share a link.
  if (!request || request->opcode >= MavFtpOpcode::kAck) return {};
  const Client client(from.system_id, from.component_id);
  if (request->opcode == MavFtpOpcode::kBurstReadFile) {
    if (Session* const session = Find(*request, client, now_s)) {
      const auto chunk = request->size == 0 ? kMavFtpMaxData : request->size;
      session->burst = Burst{static_cast<std::uint16_t>(request->sequence + 1), request->offset,
                             static_cast<std::uint8_t>(chunk), options_.burst_packets, now_s};
      return Poll(now_s);
    }
    return {EncodeMavFtp(Nak(*request, MavFtpError::kInvalidSession), client.first, client.second)};
  }
  if (!answered_.contains(client) && answered_.size() >= kRememberedClients) answered_.clear();
  auto& answered = answered_[client];
  const auto known = std::ranges::find_if(answered, [&](const Answered& answer) {
    return answer.request == *request && now_s - answer.time_s < kRememberS;
  });
  MavFtpPayload reply;
  if (known != answered.end()) {
    reply = known->reply;
  } else {
    reply = Answer(*request, client, now_s);
    answered.push_back({*request, reply, now_s});
    if (answered.size() > kRememberedAnswers) answered.pop_front();
  }
  return {EncodeMavFtp(reply, client.first, client.second)};
}

MavFtpPayload MavFtpServer::NextOfBurst(std::uint8_t id, Session* session) {
  Burst& burst = *session->burst;
  MavFtpPayload request;
  request.sequence = static_cast<std::uint16_t>(burst.sequence++ - 1);
  request.session = id;
  request.opcode = MavFtpOpcode::kBurstReadFile;
  request.offset = burst.offset;
  std::vector<std::uint8_t> data = ReadAt(&session->file, burst.offset, burst.chunk);
  if (data.empty()) {
    session->burst.reset();
    return Nak(request, MavFtpError::kEndOfFile);
  }
  burst.offset += static_cast<std::uint32_t>(data.size());
  burst.due_s += 1 / options_.packets_per_s;
  MavFtpPayload packet = Ack(request, std::move(data));
  packet.burst_complete = --burst.packets_left == 0;
  if (packet.burst_complete) session->burst.reset();
  return packet;
}

std::vector<MavFileTransferProtocol> MavFtpServer::Poll(double now_s) {
  std::vector<MavFileTransferProtocol> packets;
  for (const auto& [id, session] : sessions_) {
    for (int i = 0; i < kMostPacketsAPoll && session->burst && session->burst->due_s <= now_s;
         ++i) {
      session->used_s = now_s;
      packets.push_back(EncodeMavFtp(NextOfBurst(id, session.get()), session->client.first,
                                     session->client.second));
    }
  }
  return packets;
}

std::optional<double> MavFtpServer::NextTimeS() const {
  std::optional<double> next_s;
  for (const auto& [id, session] : sessions_) {
    if (!session->burst) continue;
    next_s = std::min(next_s.value_or(session->burst->due_s), session->burst->due_s);
  }
  return next_s;
}

}  // namespace colmap_ext
