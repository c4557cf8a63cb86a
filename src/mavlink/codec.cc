#include "colmap_ext/mavlink/codec.h"

#include <algorithm>

namespace colmap_ext {
namespace {

constexpr std::size_t kHeaderV1 = 6;
constexpr std::size_t kHeaderV2 = 10;
constexpr std::size_t kChecksumLength = 2;
constexpr std::size_t kSignatureLength = 13;
// No dialect has ids above 16 bits: a start byte before such an id was none.
constexpr std::uint32_t kGreatestPlausibleId = 0xFFFF;

bool IsMagic(std::uint8_t byte) { return byte == kMavMagicV1 || byte == kMavMagicV2; }

MavSignature ReadSignature(const std::uint8_t* bytes) {
  MavSignature signature;
  signature.link_id = bytes[0];
  for (std::size_t i = 0; i < 6; ++i) {
    signature.timestamp |= static_cast<std::uint64_t>(bytes[1 + i]) << (8U * i);
  }
  std::copy_n(bytes + 7, signature.hash.size(), signature.hash.begin());
  return signature;
}

MavFrame ReadFrame(std::span<const std::uint8_t> bytes) {
  MavFrame frame;
  frame.version = bytes[0] == kMavMagicV1 ? 1 : 2;
  frame.payload_length = bytes[1];
  std::size_t header = kHeaderV1;
  if (frame.version == 1) {
    frame.sequence = bytes[2];
    frame.system_id = bytes[3];
    frame.component_id = bytes[4];
    frame.message_id = bytes[5];
  } else {
    header = kHeaderV2;
    frame.incompat_flags = bytes[2];
    frame.compat_flags = bytes[3];
    frame.sequence = bytes[4];
    frame.system_id = bytes[5];
    frame.component_id = bytes[6];
    frame.message_id = static_cast<std::uint32_t>(bytes[7] | bytes[8] << 8U | bytes[9] << 16U);
  }
  std::copy_n(bytes.data() + header, frame.payload_length, frame.payload.begin());
  const std::uint8_t* checksum = bytes.data() + header + frame.payload_length;
  frame.checksum = static_cast<std::uint16_t>(checksum[0] | checksum[1] << 8U);
  if ((frame.incompat_flags & kMavSignedFlag) != 0) {
    frame.signature = ReadSignature(checksum + kChecksumLength);
  }
  return frame;
}

}  // namespace

MavParser::Step MavParser::TakeOne(const std::function<void(const MavFrame&)>& receive) {
  const std::span<const std::uint8_t> bytes(buffer_.data() + start_, buffer_.size() - start_);
  if (bytes.empty()) return Step::kNeedMore;
  if (!IsMagic(bytes[0])) return Step::kSkippedByte;
  const bool is_v2 = bytes[0] == kMavMagicV2;
  const std::size_t header = is_v2 ? kHeaderV2 : kHeaderV1;
  if (is_v2 && bytes.size() > 2 && (bytes[2] & ~kMavSignedFlag) != 0) {
    ++counts_.unsupported_flags;
    return Step::kSkippedByte;
  }
  if (bytes.size() < header) return Step::kNeedMore;
  const bool is_signed = is_v2 && (bytes[2] & kMavSignedFlag) != 0;
  const std::uint32_t id =
      is_v2 ? static_cast<std::uint32_t>(bytes[7] | bytes[8] << 8U | bytes[9] << 16U) : bytes[5];
  if (id > kGreatestPlausibleId) return Step::kSkippedByte;
  const std::size_t length =
      header + bytes[1] + kChecksumLength + (is_signed ? kSignatureLength : 0);
  if (bytes.size() < length) return Step::kNeedMore;

  const MavMessageInfo* const info = FindMavMessage(id);
  if (info == nullptr) {
    if (bytes.size() > length && !IsMagic(bytes[length])) return Step::kSkippedByte;
    ++counts_.unknown_messages;
    start_ += length;
    return Step::kConsumed;
  }
  const MavFrame frame = ReadFrame(bytes);
  // MAVLink 1 cuts nothing off: a payload that is shorter than the message is damage.
  if (MavChecksumOf(frame, info->crc_extra) != frame.checksum ||
      (!is_v2 && frame.payload_length < info->base_length)) {
    ++counts_.bad_checksums;
    return Step::kSkippedByte;
  }
  start_ += length;
  ++counts_.frames;
  receive(frame);
  return Step::kConsumed;
}

void MavParser::Feed(std::span<const std::uint8_t> bytes,
                     const std::function<void(const MavFrame&)>& receive) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(start_));
  start_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  while (true) {
    const Step step = TakeOne(receive);
    if (step == Step::kNeedMore) return;
    if (step == Step::kSkippedByte) {
      ++start_;
      ++counts_.skipped_bytes;
    }
  }
}

void MavParser::EndOfDatagram(const std::function<void(const MavFrame&)>& receive) {
  while (start_ < buffer_.size()) {
    if (TakeOne(receive) == Step::kConsumed) continue;
    ++start_;
    ++counts_.skipped_bytes;
  }
}

bool MavDispatcher::Dispatch(const MavFrame& frame) const {
  const auto found = handlers_.find(frame.message_id);
  if (found == handlers_.end()) return false;
  for (const auto& handle : found->second) handle(frame);
  return true;
}

}  // namespace colmap_ext
