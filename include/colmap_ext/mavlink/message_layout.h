// What a message struct says about itself, and what follows from it at compile time: the order of
// fields on the wire, their offsets, the lengths and CRC_EXTRA (mavlink.io, "Packet
// serialization").
//
// A message is a plain struct with
//   static constexpr std::uint32_t kId;       // message id, below 2^24
//   static constexpr std::string_view kName;  // name in MAVLink's definitions: enters CRC_EXTRA
//   static constexpr auto Fields();           // tuple of MavField and MavExtension, in their order
// On the wire the fields come sorted by the size of their element type, largest first, equal sizes
// in the order of declaration; extension fields follow unsorted and do not enter CRC_EXTRA.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace colmap_ext {

template <typename Message, typename Type>
struct MavFieldInfo {
  std::string_view name;
  Type Message::*member;
  bool is_extension = false;
};

template <typename Message, typename Type>
constexpr MavFieldInfo<Message, Type> MavField(std::string_view name, Type Message::*member) {
  return {name, member, false};
}
template <typename Message, typename Type>
constexpr MavFieldInfo<Message, Type> MavExtension(std::string_view name, Type Message::*member) {
  return {name, member, true};
}

// CRC-16/MCRF4XX, which MAVLink uses for packets and for CRC_EXTRA.
class MavCrc {
 public:
  constexpr void Add(std::uint8_t byte) {
    std::uint8_t mixed = static_cast<std::uint8_t>(byte ^ (value_ & 0xFFU));
    mixed = static_cast<std::uint8_t>(mixed ^ (mixed << 4U));
    value_ =
        static_cast<std::uint16_t>((value_ >> 8U) ^ (mixed << 8U) ^ (mixed << 3U) ^ (mixed >> 4U));
  }
  constexpr void Add(std::string_view text) {
    for (const char letter : text) Add(static_cast<std::uint8_t>(letter));
  }
  constexpr std::uint16_t Value() const { return value_; }

 private:
  std::uint16_t value_ = 0xFFFF;
};

// Element type, number of elements (0: not an array) and wire name of a field's type.
template <typename Type>
struct MavTypeOf {
  static_assert(std::is_arithmetic_v<Type> || std::is_enum_v<Type>);
  using Element = Type;
  static constexpr std::size_t kArrayLength = 0;
};
template <typename Type, std::size_t kLength>
struct MavTypeOf<std::array<Type, kLength>> {
  using Element = Type;
  static constexpr std::size_t kArrayLength = kLength;
};

template <typename Type>
constexpr std::string_view MavTypeName() {
  if constexpr (std::is_enum_v<Type>) {
    return MavTypeName<std::underlying_type_t<Type>>();
  } else if constexpr (std::is_same_v<Type, char>) {
    return "char";
  } else if constexpr (std::is_same_v<Type, float>) {
    return "float";
  } else if constexpr (std::is_same_v<Type, double>) {
    return "double";
  } else {
    constexpr bool kSigned = std::is_signed_v<Type>;
    switch (sizeof(Type)) {
      case 1:
        return kSigned ? "int8_t" : "uint8_t";
      case 2:
        return kSigned ? "int16_t" : "uint16_t";
      case 4:
        return kSigned ? "int32_t" : "uint32_t";
      default:
        return kSigned ? "int64_t" : "uint64_t";
    }
  }
}

// One field as the layout needs it, free of its C++ type.
struct MavFieldShape {
  std::string_view name;
  std::string_view type;
  std::size_t element_size = 0;
  std::size_t array_length = 0;  // 0: not an array
  bool is_extension = false;
  std::size_t offset = 0;  // in the payload
  constexpr std::size_t Size() const {
    return element_size * (array_length == 0 ? 1 : array_length);
  }
};

// The most bytes that a payload can have.
inline constexpr std::size_t kMavMaxPayload = 255;

template <typename Message>
inline constexpr std::size_t kMavFieldCount = std::tuple_size_v<decltype(Message::Fields())>;

template <typename Message>
struct MavLayout {
  std::array<MavFieldShape, kMavFieldCount<Message>> fields;      // as declared
  std::array<std::size_t, kMavFieldCount<Message>> wire_order{};  // indices into fields
  std::size_t base_length = 0;                                    // without extensions
  std::size_t length = 0;                                         // with them
  std::uint8_t crc_extra = 0;
};

namespace mav_layout_internal {

template <typename Message, typename Type>
constexpr MavFieldShape ShapeOf(const MavFieldInfo<Message, Type>& field) {
  using Of = MavTypeOf<Type>;
  return {field.name,
          MavTypeName<typename Of::Element>(),
          sizeof(typename Of::Element),
          Of::kArrayLength,
          field.is_extension,
          0};
}

template <typename Message>
constexpr std::uint8_t CrcExtraOf(const MavLayout<Message>& layout) {
  MavCrc crc;
  crc.Add(Message::kName);
  crc.Add(" ");
  for (const std::size_t index : layout.wire_order) {
    const MavFieldShape& field = layout.fields[index];
    if (field.is_extension) continue;
    crc.Add(field.type);
    crc.Add(" ");
    crc.Add(field.name);
    crc.Add(" ");
    if (field.array_length > 0) crc.Add(static_cast<std::uint8_t>(field.array_length));
  }
  return static_cast<std::uint8_t>((crc.Value() & 0xFFU) ^ (crc.Value() >> 8U));
}

template <typename Message>
constexpr MavLayout<Message> MakeLayout() {
  MavLayout<Message> layout{std::apply(
      [](const auto&... field) { return std::array{ShapeOf(field)...}; }, Message::Fields())};
  std::size_t placed = 0;
  std::size_t offset = 0;
  const auto place = [&](std::size_t index) {
    layout.fields[index].offset = offset;
    offset += layout.fields[index].Size();
    layout.wire_order[placed++] = index;
  };
  for (const std::size_t size : {8U, 4U, 2U, 1U}) {
    for (std::size_t i = 0; i < layout.fields.size(); ++i) {
      const MavFieldShape& field = layout.fields[i];
      if (!field.is_extension && field.element_size == size) place(i);
    }
  }
  layout.base_length = offset;
  for (std::size_t i = 0; i < layout.fields.size(); ++i) {
    if (layout.fields[i].is_extension) place(i);
  }
  layout.length = offset;
  layout.crc_extra = CrcExtraOf(layout);
  return layout;
}

}  // namespace mav_layout_internal

template <typename Message>
inline constexpr MavLayout<Message> kMavLayout = mav_layout_internal::MakeLayout<Message>();

}  // namespace colmap_ext
