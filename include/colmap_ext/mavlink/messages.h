// All messages that we speak, and the list of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "colmap_ext/mavlink/messages_camera.h"
#include "colmap_ext/mavlink/messages_health.h"
#include "colmap_ext/mavlink/messages_mission.h"
#include "colmap_ext/mavlink/messages_state.h"
#include "colmap_ext/mavlink/messages_vehicle.h"

namespace colmap_ext {

template <typename... Messages>
struct MavMessageList {
  static constexpr std::size_t kSize = sizeof...(Messages);
};

using MavMessages = MavMessageList<
    MavHeartbeat, MavSysStatus, MavSystemTime, MavPing, MavParamRequestRead, MavParamRequestList,
    MavParamValue, MavParamSet, MavGpsRawInt, MavAttitude, MavAttitudeQuaternion,
    MavLocalPositionNed, MavGlobalPositionInt, MavMissionRequest, MavMissionCurrent,
    MavMissionRequestList, MavMissionCount, MavMissionClearAll, MavMissionItemReached,
    MavMissionAck, MavGpsGlobalOrigin, MavMissionRequestInt, MavRcChannels, MavMissionItemInt,
    MavVfrHud, MavCommandInt, MavCommandLong, MavCommandAck, MavCommandCancel,
    MavSetPositionTargetGlobalInt, MavPositionTargetGlobalInt, MavRadioStatus,
    MavFileTransferProtocol, MavTimesync, MavAltitude, MavBatteryStatus, MavAutopilotVersion,
    MavMountStatus, MavFenceStatus, MavWind, MavCameraFeedback, MavEkfStatusReport,
    MavEstimatorStatus, MavWindCov, MavHomePosition, MavExtendedSysState, MavStatustext,
    MavSetupSigning, MavCameraInformation, MavCameraSettings, MavStorageInformation,
    MavCameraCaptureStatus, MavCameraImageCaptured, MavMountOrientation,
    MavGimbalManagerInformation, MavGimbalManagerStatus, MavGimbalDeviceInformation,
    MavGimbalDeviceAttitudeStatus, MavGimbalManagerSetPitchyaw>;

// What a receiver must know of a message before it knows its struct.
struct MavMessageInfo {
  std::uint32_t id = 0;
  std::string_view name;
  std::uint8_t crc_extra = 0;
  std::size_t base_length = 0;  // payload without extensions, bytes
  std::size_t length = 0;       // with them
};

// Null when we do not know the message.
const MavMessageInfo* FindMavMessage(std::uint32_t id);

// Text of a char array up to its first NUL; on the wire there is none when the text fills the
// array.
template <std::size_t kLength>
std::string MavText(const std::array<char, kLength>& field) {
  std::string text(field.begin(), field.end());
  return text.substr(0, text.find('\0'));
}
// Sets a char array; what does not fit is cut off.
template <std::size_t kLength>
void SetMavText(std::string_view text, std::array<char, kLength>* field) {
  field->fill('\0');
  for (std::size_t i = 0; i < kLength && i < text.size(); ++i) (*field)[i] = text[i];
}

}  // namespace colmap_ext
