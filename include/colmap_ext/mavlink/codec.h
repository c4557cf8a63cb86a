// Messages to packets and back. Nothing here touches a socket or a clock.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "colmap_ext/mavlink/frame.h"
#include "colmap_ext/mavlink/message_layout.h"
#include "colmap_ext/mavlink/messages.h"

namespace colmap_ext {

// Who sends, and the number of the packet among all that this component sends on this link (wraps).
struct MavHeader {
  std::uint8_t system_id = 0;
  std::uint8_t component_id = 0;
  std::uint8_t sequence = 0;
};

namespace mav_codec_internal {

template <typename Type>
void Store(Type value, std::uint8_t* bytes) {
  if constexpr (std::is_enum_v<Type>) {
    Store(static_cast<std::underlying_type_t<Type>>(value), bytes);
  } else if constexpr (std::is_same_v<Type, float>) {
    Store(std::bit_cast<std::uint32_t>(value), bytes);
  } else {
    auto bits = static_cast<std::make_unsigned_t<Type>>(value);
    for (std::size_t i = 0; i < sizeof(Type); ++i) {
      bytes[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(bits) >> (8U * i));
    }
  }
}

template <typename Type>
Type Load(const std::uint8_t* bytes) {
  if constexpr (std::is_enum_v<Type>) {
    return static_cast<Type>(Load<std::underlying_type_t<Type>>(bytes));
  } else if constexpr (std::is_same_v<Type, float>) {
    return std::bit_cast<float>(Load<std::uint32_t>(bytes));
  } else {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(Type); ++i) {
      bits |= static_cast<std::uint64_t>(bytes[i]) << (8U * i);
    }
    return static_cast<Type>(bits);
  }
}

// Calls visit(member, offset of the field) for every field of `message`.
template <typename Message, typename Struct, typename Visit>
void VisitFields(Struct& message, const Visit& visit) {
  constexpr auto kFields = Message::Fields();
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (visit(message.*(std::get<kIndex>(kFields).member), kMavLayout<Message>.fields[kIndex].offset),
     ...);
  }
  (std::make_index_sequence<kMavFieldCount<Message>>());
}

template <typename Type>
void StoreField(const Type& value, std::uint8_t* bytes) {
  Store(value, bytes);
}
template <typename Type, std::size_t kLength>
void StoreField(const std::array<Type, kLength>& values, std::uint8_t* bytes) {
  for (std::size_t i = 0; i < kLength; ++i) Store(values[i], bytes + i * sizeof(Type));
}
template <typename Type>
void LoadField(const std::uint8_t* bytes, Type* value) {
  *value = Load<Type>(bytes);
}
template <typename Type, std::size_t kLength>
void LoadField(const std::uint8_t* bytes, std::array<Type, kLength>* values) {
  for (std::size_t i = 0; i < kLength; ++i) (*values)[i] = Load<Type>(bytes + i * sizeof(Type));
}

}  // namespace mav_codec_internal

// Version 2, unsigned: trailing zeros of the payload cut off (one byte stays), checksum computed.
template <typename Message>
MavFrame MakeMavFrame(const Message& message, const MavHeader& header) {
  MavFrame frame;
  frame.sequence = header.sequence;
  frame.system_id = header.system_id;
  frame.component_id = header.component_id;
  frame.message_id = Message::kId;
  mav_codec_internal::VisitFields<Message>(message, [&](const auto& value, std::size_t offset) {
    mav_codec_internal::StoreField(value, frame.payload.data() + offset);
  });
  std::size_t length = kMavLayout<Message>.length;
  while (length > 1 && frame.payload[length - 1] == 0) --length;
  frame.payload_length = static_cast<std::uint8_t>(length);
  frame.checksum = MavChecksumOf(frame, kMavLayout<Message>.crc_extra);
  return frame;
}

// The same as bytes.
template <typename Message>
std::vector<std::uint8_t> PackMav(const Message& message, const MavHeader& header) {
  return MavFrameBytes(MakeMavFrame(message, header));
}

// The message in a frame; nothing when the frame carries another one. Bytes that the sender cut off
// or did not know are zero, bytes that we do not know are ignored.
template <typename Message>
std::optional<Message> UnpackMav(const MavFrame& frame) {
  if (frame.message_id != Message::kId) return std::nullopt;
  Message message;
  mav_codec_internal::VisitFields<Message>(message, [&](auto& value, std::size_t offset) {
    mav_codec_internal::LoadField(frame.payload.data() + offset, &value);
  });
  return message;
}

// What a parser has seen.
struct MavParserCounts {
  std::uint64_t frames = 0;             // given out
  std::uint64_t unknown_messages = 0;   // well-framed, but we do not know the message: skipped
  std::uint64_t bad_checksums = 0;      // a start byte whose checksum does not fit
  std::uint64_t unsupported_flags = 0;  // incompatibility flags that we do not know
  std::uint64_t skipped_bytes = 0;      // not part of any packet
};

// Finds packets in a stream of bytes that may be split anywhere and damaged anywhere. After damage
// it goes on one byte behind the start byte that misled it, so that no intact packet is lost but
// one that a damaged length has swallowed in part. A message that we do not know cannot be
// verified; it is skipped when another packet, or the end of what has arrived, follows it.
class MavParser {
 public:
  // Takes `bytes` and calls `receive` for every packet that is complete now, in order.
  void Feed(std::span<const std::uint8_t> bytes,
            const std::function<void(const MavFrame&)>& receive);
  // The next bytes do not continue the last ones: a datagram ended or the link was opened again.
  // What waits for its rest is searched for whole packets, then dropped.
  void EndOfDatagram(const std::function<void(const MavFrame&)>& receive);
  const MavParserCounts& Counts() const { return counts_; }

 private:
  enum class Step { kNeedMore, kSkippedByte, kConsumed };
  Step TakeOne(const std::function<void(const MavFrame&)>& receive);

  std::vector<std::uint8_t> buffer_;
  std::size_t start_ = 0;  // of what is not consumed yet, in buffer_
  MavParserCounts counts_;
};

// Calls the functions that were registered for a frame's message.
class MavDispatcher {
 public:
  template <typename Message>
  void On(std::function<void(const Message&, const MavFrame&)> handle) {
    handlers_[Message::kId].push_back([handle = std::move(handle)](const MavFrame& frame) {
      handle(*UnpackMav<Message>(frame), frame);
    });
  }
  // Whether anyone was called.
  bool Dispatch(const MavFrame& frame) const;

 private:
  std::map<std::uint32_t, std::vector<std::function<void(const MavFrame&)>>> handlers_;
};

// Numbers and packs what one component sends on one link.
class MavSender {
 public:
  MavSender(std::uint8_t system_id, std::uint8_t component_id)
      : next_{system_id, component_id, 0} {}
  template <typename Message>
  MavFrame Next(const Message& message) {
    const MavFrame frame = MakeMavFrame(message, next_);
    ++next_.sequence;
    return frame;
  }
  std::uint8_t SystemId() const { return next_.system_id; }
  std::uint8_t ComponentId() const { return next_.component_id; }

 private:
  MavHeader next_;
};

}  // namespace colmap_ext
