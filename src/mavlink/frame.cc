#include "colmap_ext/mavlink/frame.h"

namespace colmap_ext {

std::vector<std::uint8_t> MavHeaderBytes(const MavFrame& frame) {
  if (frame.version == 1) {
    return {kMavMagicV1,     frame.payload_length, frame.sequence,
            frame.system_id, frame.component_id,   static_cast<std::uint8_t>(frame.message_id)};
  }
  return {kMavMagicV2,
          frame.payload_length,
          frame.incompat_flags,
          frame.compat_flags,
          frame.sequence,
          frame.system_id,
          frame.component_id,
          static_cast<std::uint8_t>(frame.message_id),
          static_cast<std::uint8_t>(frame.message_id >> 8U),
          static_cast<std::uint8_t>(frame.message_id >> 16U)};
}

std::uint16_t MavChecksumOf(const MavFrame& frame, std::uint8_t crc_extra) {
  MavCrc crc;
  const std::vector<std::uint8_t> header = MavHeaderBytes(frame);
  for (std::size_t i = 1; i < header.size(); ++i) crc.Add(header[i]);
  for (const std::uint8_t byte : frame.Payload()) crc.Add(byte);
  crc.Add(crc_extra);
  return crc.Value();
}

std::vector<std::uint8_t> MavFrameBytes(const MavFrame& frame) {
  std::vector<std::uint8_t> bytes = MavHeaderBytes(frame);
  bytes.reserve(kMavMaxFrame);
  bytes.insert(bytes.end(), frame.Payload().begin(), frame.Payload().end());
  bytes.push_back(static_cast<std::uint8_t>(frame.checksum));
  bytes.push_back(static_cast<std::uint8_t>(frame.checksum >> 8U));
  if (frame.signature) {
    bytes.push_back(frame.signature->link_id);
    for (std::size_t i = 0; i < 6; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(frame.signature->timestamp >> (8U * i)));
    }
    bytes.insert(bytes.end(), frame.signature->hash.begin(), frame.signature->hash.end());
  }
  return bytes;
}

}  // namespace colmap_ext
