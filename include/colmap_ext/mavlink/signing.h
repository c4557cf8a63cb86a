// Signed packets (mavlink.io, "Message signing"): the last six bytes of a packet are the first six
// of SHA-256(key, header, payload, checksum, link id, timestamp).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "colmap_ext/mavlink/frame.h"
#include "colmap_ext/mavlink/messages_state.h"

namespace colmap_ext {

using MavSigningKey = std::array<std::uint8_t, 32>;

// Reads 32 raw bytes or 64 hexadecimal digits (white space around them is allowed). Throws Error
// when the file has anything else, cannot be read, or may be read by other users.
MavSigningKey ReadMavSigningKey(const std::filesystem::path& path);

// 10 us since 2015-01-01 00:00 UTC; 0 before that. `unix_s`: seconds since 1970.
std::uint64_t MavTimestamp(double unix_s);

// What must outlive the program, so that neither our timestamps nor those that we accept go back.
struct MavSigningState {
  std::uint64_t timestamp = 0;  // ours; everything up to it may have been used
  // Last timestamp accepted from (system, component, link).
  std::map<std::tuple<std::uint8_t, std::uint8_t, std::uint8_t>, std::uint64_t> streams;
  bool operator==(const MavSigningState&) const = default;
};

// A file that is not there is an empty state. Throws Error when the file is damaged.
MavSigningState ReadMavSigningState(const std::filesystem::path& path);
void WriteMavSigningState(const std::filesystem::path& path, const MavSigningState& state);

enum class MavSignatureVerdict {
  kAccepted,
  kUnsigned,  // no signature, and the message is not among those that may come without
  kWrong,     // made with another key, or damaged
  kReplayed,  // its timestamp is not above the last one of its stream
  kTooOld,    // first of its stream, and more than a minute behind us
};

struct MavSigningCounts {
  std::uint64_t accepted = 0;
  std::uint64_t without_signature = 0;
  std::uint64_t wrong = 0;
  std::uint64_t replayed = 0;
  std::uint64_t too_old = 0;
};

struct MavSigningOptions {
  std::uint8_t link_id = 0;
  // Messages that are accepted without a signature: a radio modem has no key (109 RADIO_STATUS).
  std::set<std::uint32_t> unsigned_messages = {109};
  // How far ahead `save` reserves timestamps, s: it is called about that often while we send, and a
  // program that was killed goes on behind what it had reserved.
  double reserve_s = 10.0;
};

// Signs what one program sends on one link and judges what it receives.
class MavSigning {
 public:
  // `state` as it was saved last; `save` keeps a new one and may throw. It is called before a
  // timestamp beyond the saved one is used.
  MavSigning(const MavSigningKey& key, MavSigningOptions options, MavSigningState state,
             std::function<void(const MavSigningState&)> save);

  // Sets flag, checksum and signature. The frame is version 2 and of a message that we know.
  void Sign(MavFrame* frame, double unix_s);
  MavSignatureVerdict Check(const MavFrame& frame, double unix_s);

  const MavSigningCounts& Counts() const { return counts_; }
  const MavSigningState& State() const { return state_; }

 private:
  MavSignatureVerdict Judge(const MavFrame& frame, double unix_s);
  std::uint64_t NextTimestamp(double unix_s);

  MavSigningKey key_;
  MavSigningOptions options_;
  MavSigningState state_;  // .timestamp: up to which timestamps are reserved
  std::uint64_t last_timestamp_;
  std::function<void(const MavSigningState&)> save_;
  MavSigningCounts counts_;
};

// The message that gives a vehicle its key. Only for a link that nobody else can hear.
MavSetupSigning MakeSetupSigning(const MavSigningKey& key, double unix_s,
                                 std::uint8_t target_system, std::uint8_t target_component);

}  // namespace colmap_ext
