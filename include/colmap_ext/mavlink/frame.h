// One packet on the wire, MAVLink 1 or 2, and its bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "colmap_ext/mavlink/message_layout.h"

namespace colmap_ext {

inline constexpr std::uint8_t kMavMagicV1 = 0xFE;
inline constexpr std::uint8_t kMavMagicV2 = 0xFD;
// The only incompatibility flag that is defined: a signature follows the checksum.
inline constexpr std::uint8_t kMavSignedFlag = 1;
// Header, payload, checksum and signature at their longest.
inline constexpr std::size_t kMavMaxFrame = 10 + kMavMaxPayload + 2 + 13;

struct MavSignature {
  std::uint8_t link_id = 0;
  std::uint64_t timestamp = 0;  // 48 bits, 10 us since 2015-01-01 UTC
  std::array<std::uint8_t, 6> hash{};
  bool operator==(const MavSignature&) const = default;
};

struct MavFrame {
  std::uint8_t version = 2;  // of MAVLink: 1 or 2
  std::uint8_t incompat_flags = 0;
  std::uint8_t compat_flags = 0;
  std::uint8_t sequence = 0;
  std::uint8_t system_id = 0;     // of the sender
  std::uint8_t component_id = 0;  // of the sender
  std::uint32_t message_id = 0;   // 24 bits; 8 in version 1
  std::uint8_t payload_length = 0;
  std::array<std::uint8_t, kMavMaxPayload> payload{};  // zero from payload_length on
  std::uint16_t checksum = 0;
  std::optional<MavSignature> signature;  // when incompat_flags has kMavSignedFlag

  std::span<const std::uint8_t> Payload() const { return {payload.data(), payload_length}; }
  bool operator==(const MavFrame&) const = default;
};

// Header as on the wire, from the magic on (10 bytes, 6 in version 1).
std::vector<std::uint8_t> MavHeaderBytes(const MavFrame& frame);
// CRC over header without magic, payload and CRC_EXTRA.
std::uint16_t MavChecksumOf(const MavFrame& frame, std::uint8_t crc_extra);
// The packet, with frame.checksum and frame.signature as they are.
std::vector<std::uint8_t> MavFrameBytes(const MavFrame& frame);

}  // namespace colmap_ext
