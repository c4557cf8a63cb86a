// Our end of a link without its input and output: packets from messages and messages from bytes,
// with numbering, signing and statistics.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/mavlink/link_statistics.h"
#include "colmap_ext/mavlink/signing.h"

namespace colmap_ext {

class MavEndpoint {
 public:
  MavEndpoint(std::uint8_t system_id, std::uint8_t component_id)
      : sender_(system_id, component_id) {}

  // From now on everything is sent signed, and what `signing` does not accept is dropped.
  void EnableSigning(MavSigning signing) { signing_.emplace(std::move(signing)); }

  // `unix_s`: seconds since 1970, for the signature.
  template <typename Message>
  std::vector<std::uint8_t> Encode(const Message& message, double unix_s) {
    MavFrame frame = sender_.Next(message);
    if (signing_) signing_->Sign(&frame, unix_s);
    return MavFrameBytes(frame);
  }

  // Calls `receive` for every packet that is intact, rightly signed and not our own. Packets that
  // came twice are among them, and counted: who receives a command twice answers it twice.
  // `now_s`: any clock that does not go back.
  void Receive(std::span<const std::uint8_t> bytes, bool ends_datagram, double now_s, double unix_s,
               const std::function<void(const MavFrame&)>& receive);

  const MavParserCounts& ParserCounts() const { return parser_.Counts(); }
  const MavLinkStatistics& Statistics() const { return statistics_; }
  const MavSigning* Signing() const { return signing_ ? &*signing_ : nullptr; }
  std::uint8_t SystemId() const { return sender_.SystemId(); }
  std::uint8_t ComponentId() const { return sender_.ComponentId(); }

 private:
  MavSender sender_;
  MavParser parser_;
  MavLinkStatistics statistics_;
  std::optional<MavSigning> signing_;
};

}  // namespace colmap_ext
