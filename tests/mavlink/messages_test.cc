#include "colmap_ext/mavlink/messages.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "mavlink/random_messages.h"

namespace colmap_ext {
namespace {

// Id and CRC_EXTRA as measured against running autopilots and as the definitions say.
const std::map<std::uint32_t, int> kMeasured = {
    {0, 50},    {1, 124},   {20, 214},  {22, 220},  {23, 168},  {24, 24},   {30, 39},   {33, 104},
    {40, 230},  {42, 28},   {44, 221},  {45, 232},  {46, 11},   {47, 153},  {51, 196},  {65, 118},
    {73, 38},   {75, 158},  {76, 152},  {77, 143},  {86, 5},    {87, 150},  {110, 84},  {147, 154},
    {148, 178}, {162, 189}, {180, 52},  {193, 71},  {230, 163}, {242, 104}, {245, 130}, {253, 83},
    {256, 71},  {259, 92},  {260, 146}, {261, 179}, {262, 12},  {263, 133}, {280, 70},  {281, 48},
    {285, 137}, {287, 1},   {2, 137},   {4, 237},   {111, 34}};

TEST(MavMessages, CrcExtraOfEveryMeasuredMessage) {
  for (const auto& [id, crc_extra] : kMeasured) {
    const MavMessageInfo* const info = FindMavMessage(id);
    ASSERT_NE(info, nullptr) << id;
    EXPECT_EQ(info->crc_extra, crc_extra) << info->name;
  }
}

TEST(MavMessages, UnknownIdsAreNotFound) {
  for (const std::uint32_t id : {3U, 288U, 65535U, 0xFFFFFFU}) {
    EXPECT_EQ(FindMavMessage(id), nullptr) << id;
  }
}

TEST(MavMessages, FieldsTileThePayloadWithoutGapOrOverlap) {
  ForEveryMavMessage([]<typename Message>() {
    constexpr auto kLayout = kMavLayout<Message>;
    std::size_t end = 0;
    std::size_t last_size = 8;
    for (const std::size_t index : kLayout.wire_order) {
      const MavFieldShape& field = kLayout.fields[index];
      EXPECT_EQ(field.offset, end) << Message::kName << "." << field.name;
      end += field.Size();
      if (field.is_extension) continue;
      EXPECT_LE(field.element_size, last_size) << Message::kName << "." << field.name;
      last_size = field.element_size;
      EXPECT_LE(end, kLayout.base_length);
    }
    EXPECT_EQ(end, kLayout.length) << Message::kName;
  });
}

TEST(MavMessages, LayoutOfCommandLongIsTheOneOnTheWire) {
  const auto& fields = kMavLayout<MavCommandLong>.fields;
  const std::map<std::string, std::size_t> expected = {
      {"param1", 0},         {"param7", 24},           {"command", 28},
      {"target_system", 30}, {"target_component", 31}, {"confirmation", 32}};
  std::size_t found = 0;
  for (const MavFieldShape& field : fields) {
    const auto entry = expected.find(std::string(field.name));
    if (entry == expected.end()) continue;
    ++found;
    EXPECT_EQ(field.offset, entry->second) << field.name;
  }
  EXPECT_EQ(found, expected.size());
}

TEST(MavMessages, ExtensionsStandBehindTheRestWhateverTheirSize) {
  EXPECT_EQ(kMavLayout<MavGpsRawInt>.base_length, 30U);
  EXPECT_EQ(kMavLayout<MavGpsRawInt>.length, 52U);
  EXPECT_EQ(kMavLayout<MavCommandAck>.base_length, 3U);
  EXPECT_EQ(kMavLayout<MavCommandAck>.length, 10U);
}

TEST(MavMessages, TextStopsAtNulAndMayFillTheField) {
  MavParamValue value;
  SetMavText("FENCE_ENABLE", &value.param_id);
  EXPECT_EQ(MavText(value.param_id), "FENCE_ENABLE");
  SetMavText("SIXTEEN_LETTERS_", &value.param_id);
  EXPECT_EQ(MavText(value.param_id), "SIXTEEN_LETTERS_");
  SetMavText("SEVENTEEN_LETTERS", &value.param_id);
  EXPECT_EQ(MavText(value.param_id), "SEVENTEEN_LETTER");
  SetMavText("A", &value.param_id);
  EXPECT_EQ(MavText(value.param_id), "A");
}

TEST(MavModes, Px4ModesPackAsMainAndSub) {
  EXPECT_EQ(ToCustomMode({Px4MainMode::kAuto, Px4AutoMode::kHold}), 0x03040000U);
  for (const Px4AutoMode sub : {Px4AutoMode::kTakeoff, Px4AutoMode::kReturn, Px4AutoMode::kLand}) {
    const Px4Mode mode{Px4MainMode::kAuto, sub};
    EXPECT_EQ(Px4ModeOf(ToCustomMode(mode)), mode);
  }
}

}  // namespace
}  // namespace colmap_ext
