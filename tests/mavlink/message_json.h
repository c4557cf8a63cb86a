// Messages as JSON, by their field tables, as tests/mavlink/peer/peer.js reads and writes them.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "colmap_ext/mavlink/messages.h"

namespace colmap_ext {

template <typename Type>
nlohmann::json MavValueJson(const Type& value) {
  if constexpr (std::is_enum_v<Type>) {
    return MavValueJson(static_cast<std::underlying_type_t<Type>>(value));
  } else if constexpr (std::is_integral_v<Type> && sizeof(Type) == 8) {
    return std::to_string(value);
  } else if constexpr (std::is_same_v<Type, float>) {
    return static_cast<double>(value);
  } else {
    return static_cast<std::int64_t>(value);
  }
}
template <typename Type, std::size_t kLength>
nlohmann::json MavValueJson(const std::array<Type, kLength>& values) {
  if constexpr (std::is_same_v<Type, char>) {
    return MavText(values);
  } else {
    nlohmann::json array = nlohmann::json::array();
    for (const Type& value : values) array.push_back(MavValueJson(value));
    return array;
  }
}

template <typename Message>
nlohmann::json MavFieldsJson(const Message& message) {
  nlohmann::json json = nlohmann::json::object();
  std::apply(
      [&](const auto&... field) {
        ((json[std::string(field.name)] = MavValueJson(message.*(field.member))), ...);
      },
      Message::Fields());
  return json;
}

}  // namespace colmap_ext
