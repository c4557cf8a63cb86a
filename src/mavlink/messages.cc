#include "colmap_ext/mavlink/messages.h"

#include <algorithm>
#include <array>
#include <type_traits>

namespace colmap_ext {
namespace {

template <typename Message>
constexpr MavMessageInfo InfoOf() {
  static_assert(std::is_trivially_copyable_v<Message>);
  static_assert(kMavLayout<Message>.length <= kMavMaxPayload);
  return {Message::kId, Message::kName, kMavLayout<Message>.crc_extra,
          kMavLayout<Message>.base_length, kMavLayout<Message>.length};
}

template <typename... Messages>
constexpr auto TableOf(MavMessageList<Messages...>) {
  return std::array{InfoOf<Messages>()...};
}

constexpr auto kTable = TableOf(MavMessages{});

// Id, CRC_EXTRA and greatest payload length of every message, as published with MAVLink's
// definitions: a wrong name, type or order of fields above does not compile.
struct Published {
  std::uint32_t id;
  std::uint8_t crc_extra;
  std::size_t length;
};
constexpr std::array<Published, MavMessages::kSize> kPublished = {
    {{0, 50, 9},     {1, 124, 43},   {2, 137, 12},    {4, 237, 14},   {20, 214, 20},
     {21, 159, 2},   {22, 220, 25},  {23, 168, 23},   {24, 24, 52},   {30, 39, 28},
     {31, 246, 48},  {32, 185, 28},  {33, 104, 28},   {40, 230, 5},   {42, 28, 18},
     {43, 132, 3},   {44, 221, 9},   {45, 232, 3},    {46, 11, 2},    {47, 153, 8},
     {49, 39, 20},   {51, 196, 5},   {65, 118, 42},   {73, 38, 38},   {74, 20, 20},
     {75, 158, 35},  {76, 152, 33},  {77, 143, 10},   {80, 14, 4},    {86, 5, 53},
     {87, 150, 51},  {109, 185, 9},  {110, 84, 254},  {111, 34, 18},  {141, 47, 32},
     {147, 154, 54}, {148, 178, 78}, {158, 134, 15},  {162, 189, 9},  {168, 1, 12},
     {180, 52, 47},  {193, 71, 26},  {230, 163, 42},  {231, 105, 40}, {242, 104, 60},
     {245, 130, 2},  {253, 83, 54},  {256, 71, 42},   {259, 92, 237}, {260, 146, 14},
     {261, 179, 61}, {262, 12, 23},  {263, 133, 255}, {265, 26, 20},  {280, 70, 33},
     {281, 48, 13},  {283, 74, 145}, {285, 137, 49},  {287, 1, 23}}};

constexpr bool TableIsAsPublished() {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    if (kTable[i].id != kPublished[i].id || kTable[i].crc_extra != kPublished[i].crc_extra ||
        kTable[i].length != kPublished[i].length) {
      return false;
    }
    if (i > 0 && kTable[i - 1].id >= kTable[i].id) return false;
  }
  return true;
}
static_assert(TableIsAsPublished());

}  // namespace

const MavMessageInfo* FindMavMessage(std::uint32_t id) {
  const auto found = std::ranges::lower_bound(kTable, id, {}, &MavMessageInfo::id);
  return found != kTable.end() && found->id == id ? &*found : nullptr;
}

}  // namespace colmap_ext
