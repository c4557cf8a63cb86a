// Messages with random values in every field, for tests that go over all messages.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <type_traits>

#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

template <typename Type>
Type RandomMavValue(std::mt19937_64* random) {
  if constexpr (std::is_enum_v<Type>) {
    return static_cast<Type>(RandomMavValue<std::underlying_type_t<Type>>(random));
  } else if constexpr (std::is_same_v<Type, float>) {
    return std::uniform_real_distribution<float>(-1000, 1000)(*random);
  } else if constexpr (std::is_same_v<Type, char>) {
    return static_cast<char>('A' + (*random)() % 26);
  } else {
    // Zero now and then, so that payloads end in bytes that are cut off.
    return (*random)() % 3 == 0 ? Type{0} : static_cast<Type>((*random)());
  }
}

template <typename Type>
void FillRandomly(std::mt19937_64* random, Type* value) {
  *value = RandomMavValue<Type>(random);
}
template <typename Type, std::size_t kLength>
void FillRandomly(std::mt19937_64* random, std::array<Type, kLength>* values) {
  for (Type& value : *values) value = RandomMavValue<Type>(random);
}

template <typename Message>
Message RandomMavMessage(std::mt19937_64* random) {
  Message message;
  std::apply([&](const auto&... field) { (FillRandomly(random, &(message.*(field.member))), ...); },
             Message::Fields());
  return message;
}

// Calls visit.operator()<Message>() for every message.
template <typename Visit>
void ForEveryMavMessage(const Visit& visit) {
  [&]<typename... Messages>(MavMessageList<Messages...>) {
    (visit.template operator()<Messages>(), ...);
  }(MavMessages{});
}

}  // namespace colmap_ext
