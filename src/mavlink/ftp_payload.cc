#include "colmap_ext/mavlink/ftp_payload.h"

#include <algorithm>
#include <charconv>

namespace colmap_ext {
namespace {

constexpr std::size_t kHeader = 12;

bool IsReadRequest(MavFtpOpcode opcode) {
  return opcode == MavFtpOpcode::kReadFile || opcode == MavFtpOpcode::kBurstReadFile;
}

bool Skip(std::string_view prefix, std::string_view* text) {
  if (!text->starts_with(prefix)) return false;
  text->remove_prefix(prefix.size());
  return true;
}

}  // namespace

std::string MavFtpErrorText(MavFtpError error) {
  switch (error) {
    case MavFtpError::kNone:
      return "no error";
    case MavFtpError::kFail:
      return "unknown failure";
    case MavFtpError::kFailErrno:
      return "failure of the file system";
    case MavFtpError::kInvalidDataSize:
      return "invalid data size";
    case MavFtpError::kInvalidSession:
      return "session is not open";
    case MavFtpError::kNoSessionsAvailable:
      return "all sessions are in use";
    case MavFtpError::kEndOfFile:
      return "end of file";
    case MavFtpError::kUnknownCommand:
      return "unknown command";
    case MavFtpError::kFileExists:
      return "file exists";
    case MavFtpError::kFileProtected:
      return "file is protected";
    case MavFtpError::kFileNotFound:
      return "file not found";
  }
  return "error " + std::to_string(static_cast<int>(error));
}

MavFileTransferProtocol EncodeMavFtp(const MavFtpPayload& payload, std::uint8_t target_system,
                                     std::uint8_t target_component) {
  MavFileTransferProtocol message;
  message.target_system = target_system;
  message.target_component = target_component;
  auto& bytes = message.payload;
  bytes[0] = static_cast<std::uint8_t>(payload.sequence);
  bytes[1] = static_cast<std::uint8_t>(payload.sequence >> 8U);
  bytes[2] = payload.session;
  bytes[3] = static_cast<std::uint8_t>(payload.opcode);
  bytes[4] = payload.size;
  bytes[5] = static_cast<std::uint8_t>(payload.request_opcode);
  bytes[6] = payload.burst_complete ? 1 : 0;
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[8 + i] = static_cast<std::uint8_t>(payload.offset >> (8U * i));
  }
  std::copy_n(payload.data.begin(), std::min(payload.data.size(), kMavFtpMaxData),
              bytes.begin() + kHeader);
  return message;
}

std::optional<MavFtpPayload> DecodeMavFtp(const MavFileTransferProtocol& message) {
  const auto& bytes = message.payload;
  MavFtpPayload payload;
  payload.sequence = static_cast<std::uint16_t>(bytes[0] | bytes[1] << 8U);
  payload.session = bytes[2];
  payload.opcode = static_cast<MavFtpOpcode>(bytes[3]);
  payload.size = bytes[4];
  payload.request_opcode = static_cast<MavFtpOpcode>(bytes[5]);
  payload.burst_complete = bytes[6] != 0;
  for (std::size_t i = 0; i < 4; ++i) {
    payload.offset |= static_cast<std::uint32_t>(bytes[8 + i]) << (8U * i);
  }
  if (payload.size > kMavFtpMaxData) return std::nullopt;
  if (!IsReadRequest(payload.opcode)) {
    payload.data.assign(bytes.begin() + kHeader, bytes.begin() + kHeader + payload.size);
  }
  return payload;
}

std::optional<MavFtpUrl> ParseMavFtpUrl(std::string_view text) {
  if (!Skip("mftp://", &text)) return std::nullopt;
  MavFtpUrl url;
  if (Skip("[", &text)) {
    Skip(";", &text);
    if (!Skip("comp=", &text)) return std::nullopt;
    unsigned component = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), component);
    if (error != std::errc() || component > 255) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
    Skip(":", &text);
    if (!Skip("]", &text)) return std::nullopt;
    url.component = static_cast<std::uint8_t>(component);
  }
  if (text.empty()) return std::nullopt;
  url.path = text;
  return url;
}

}  // namespace colmap_ext
