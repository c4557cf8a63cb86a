// What stands inside FILE_TRANSFER_PROTOCOL (mavlink.io, "File Transfer Protocol"), and addresses
// of files that are fetched by it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "colmap_ext/mavlink/messages_state.h"

namespace colmap_ext {

enum class MavFtpOpcode : std::uint8_t {
  kNone = 0,
  kTerminateSession = 1,
  kResetSessions = 2,
  kListDirectory = 3,
  kOpenFileRo = 4,
  kReadFile = 5,
  kBurstReadFile = 15,
  kAck = 128,
  kNak = 129,
};

enum class MavFtpError : std::uint8_t {
  kNone = 0,
  kFail = 1,
  kFailErrno = 2,  // data[1] is the number
  kInvalidDataSize = 3,
  kInvalidSession = 4,
  kNoSessionsAvailable = 5,
  kEndOfFile = 6,
  kUnknownCommand = 7,
  kFileExists = 8,
  kFileProtected = 9,
  kFileNotFound = 10,
};
std::string MavFtpErrorText(MavFtpError error);  // "file not found"

inline constexpr std::size_t kMavFtpMaxData = 239;

struct MavFtpPayload {
  std::uint16_t sequence = 0;
  std::uint8_t session = 0;
  MavFtpOpcode opcode = MavFtpOpcode::kNone;
  std::uint8_t size = 0;  // of data, but in a read request: bytes that are wanted
  MavFtpOpcode request_opcode = MavFtpOpcode::kNone;
  bool burst_complete = false;
  std::uint32_t offset = 0;
  std::vector<std::uint8_t> data;  // at most kMavFtpMaxData
  bool operator==(const MavFtpPayload&) const = default;

  std::string_view Text() const {
    return {reinterpret_cast<const char*>(data.data()), data.size()};
  }
  // Of a NAK.
  MavFtpError Error() const {
    return data.empty() ? MavFtpError::kFail : static_cast<MavFtpError>(data[0]);
  }
};

MavFileTransferProtocol EncodeMavFtp(const MavFtpPayload& payload, std::uint8_t target_system,
                                     std::uint8_t target_component);
// Nothing when `size` says more than a payload can have. A read request has no data.
std::optional<MavFtpPayload> DecodeMavFtp(const MavFileTransferProtocol& message);

// mftp://path, mftp://[;comp=100]path or mftp://[comp=100:]path
struct MavFtpUrl {
  std::optional<std::uint8_t> component;  // nothing: whoever gave the address
  std::string path;
  bool operator==(const MavFtpUrl&) const = default;
};
// Nothing when it is none.
std::optional<MavFtpUrl> ParseMavFtpUrl(std::string_view text);

}  // namespace colmap_ext
