// The values of MAVLink's enumerations that we use, and the flight modes of both autopilots. A
// number that is not listed may still arrive: every enum class here may hold any value of its type.
#pragma once

#include <cstdint>

namespace colmap_ext {

enum class MavType : std::uint8_t {
  kGeneric = 0,
  kFixedWing = 1,
  kQuadrotor = 2,
  kCoaxial = 3,
  kHelicopter = 4,
  kAntennaTracker = 5,
  kGcs = 6,
  kHexarotor = 13,
  kOctorotor = 14,
  kTricopter = 15,
  kOnboardController = 18,
  kGimbal = 26,
  kAdsb = 27,
  kDodecarotor = 29,
  kCamera = 30,
};

enum class MavAutopilot : std::uint8_t {
  kGeneric = 0,
  kArduPilot = 3,
  kInvalid = 8,  // not a flight controller: a ground station, a camera, a gimbal
  kPx4 = 12,
};

enum class MavState : std::uint8_t {
  kUninit = 0,
  kBoot = 1,
  kCalibrating = 2,
  kStandby = 3,
  kActive = 4,
  kCritical = 5,
  kEmergency = 6,
  kPoweroff = 7,
  kFlightTermination = 8,
};

// Bits of HEARTBEAT.base_mode.
struct MavModeFlag {
  static constexpr std::uint8_t kCustomModeEnabled = 1;
  static constexpr std::uint8_t kTestEnabled = 2;
  static constexpr std::uint8_t kAutoEnabled = 4;
  static constexpr std::uint8_t kGuidedEnabled = 8;
  static constexpr std::uint8_t kStabilizeEnabled = 16;
  static constexpr std::uint8_t kHilEnabled = 32;
  static constexpr std::uint8_t kManualInputEnabled = 64;
  static constexpr std::uint8_t kSafetyArmed = 128;
};

// Components of a system.
struct MavComponent {
  static constexpr std::uint8_t kAll = 0;
  static constexpr std::uint8_t kAutopilot = 1;
  static constexpr std::uint8_t kCamera = 100;
  static constexpr std::uint8_t kGimbal = 154;
  static constexpr std::uint8_t kMissionPlanner = 190;
  static constexpr std::uint8_t kOnboardComputer = 191;
};

enum class MavSeverity : std::uint8_t {
  kEmergency = 0,
  kAlert = 1,
  kCritical = 2,
  kError = 3,
  kWarning = 4,
  kNotice = 5,
  kInfo = 6,
  kDebug = 7,
};

enum class MavParamType : std::uint8_t {
  kUint8 = 1,
  kInt8 = 2,
  kUint16 = 3,
  kInt16 = 4,
  kUint32 = 5,
  kInt32 = 6,
  kReal32 = 9,
};

enum class MavGpsFixType : std::uint8_t {
  kNoGps = 0,
  kNoFix = 1,
  k2dFix = 2,
  k3dFix = 3,
  kDgps = 4,
  kRtkFloat = 5,
  kRtkFixed = 6,
  kStatic = 7,
  kPpp = 8,
};

// MAV_FRAME. kGlobal and kGlobalInt mean the same; so do the relative and the terrain pair.
enum class MavCoordinateFrame : std::uint8_t {
  kGlobal = 0,  // height above mean sea level
  kLocalNed = 1,
  kMission = 2,            // not a place
  kGlobalRelativeAlt = 3,  // height above home
  kGlobalInt = 5,
  kGlobalRelativeAltInt = 6,
  kGlobalTerrainAlt = 10,  // height above the ground below
  kGlobalTerrainAltInt = 11,
};

enum class MavCmd : std::uint16_t {
  kNavWaypoint = 16,
  kNavReturnToLaunch = 20,
  kNavLand = 21,
  kNavTakeoff = 22,
  kNavDelay = 93,
  kConditionYaw = 115,
  kDoSetMode = 176,
  kDoChangeSpeed = 178,
  kDoReposition = 192,
  kDoPauseContinue = 193,
  kDoDigicamControl = 203,
  kDoMountControl = 205,
  kDoFenceEnable = 207,
  kMissionStart = 300,
  kComponentArmDisarm = 400,
  kRunPrearmChecks = 401,
  kGetHomePosition = 410,
  kSetMessageInterval = 511,
  kRequestMessage = 512,
  kRequestAutopilotCapabilities = 520,
  kRequestCameraInformation = 521,
  kSetCameraMode = 530,
  kDoGimbalManagerPitchyaw = 1000,
  kDoGimbalManagerConfigure = 1001,
  kImageStartCapture = 2000,
  kImageStopCapture = 2001,
  kNavFenceReturnPoint = 5000,
  kNavFencePolygonVertexInclusion = 5001,
  kNavFencePolygonVertexExclusion = 5002,
  kNavFenceCircleInclusion = 5003,
  kNavFenceCircleExclusion = 5004,
  kNavRallyPoint = 5100,
};

enum class MavResult : std::uint8_t {
  kAccepted = 0,
  kTemporarilyRejected = 1,
  kDenied = 2,
  kUnsupported = 3,
  kFailed = 4,
  kInProgress = 5,
  kCancelled = 6,
  kCommandLongOnly = 7,
  kCommandIntOnly = 8,
  kUnsupportedFrame = 9,
};

enum class MavMissionResult : std::uint8_t {
  kAccepted = 0,
  kError = 1,
  kUnsupportedFrame = 2,
  kUnsupported = 3,
  kNoSpace = 4,
  kInvalid = 5,
  kInvalidParam1 = 6,
  kInvalidParam2 = 7,
  kInvalidParam3 = 8,
  kInvalidParam4 = 9,
  kInvalidParam5X = 10,
  kInvalidParam6Y = 11,
  kInvalidParam7 = 12,
  kInvalidSequence = 13,
  kDenied = 14,
  kOperationCancelled = 15,
};

enum class MavMissionType : std::uint8_t { kMission = 0, kFence = 1, kRally = 2, kAll = 255 };

enum class MavMissionState : std::uint8_t {
  kUnknown = 0,
  kNoMission = 1,
  kNotStarted = 2,
  kActive = 3,
  kPaused = 4,
  kComplete = 5,
};

// Bit of DO_REPOSITION's param2: go to guided (hold) mode for it.
inline constexpr float kMavRepositionChangeMode = 1.0F;

// Bits of POSITION_TARGET's type_mask: what the receiver shall ignore.
struct MavTargetIgnore {
  static constexpr std::uint16_t kPosition = 1 | 2 | 4;
  static constexpr std::uint16_t kVelocity = 8 | 16 | 32;
  static constexpr std::uint16_t kAcceleration = 64 | 128 | 256;
  static constexpr std::uint16_t kYaw = 1024;
  static constexpr std::uint16_t kYawRate = 2048;
};

enum class MavLandedState : std::uint8_t {
  kUndefined = 0,
  kOnGround = 1,
  kInAir = 2,
  kTakeoff = 3,
  kLanding = 4,
};

enum class MavFenceBreach : std::uint8_t { kNone = 0, kMinAlt = 1, kMaxAlt = 2, kBoundary = 3 };

enum class MavBatteryChargeState : std::uint8_t {
  kUndefined = 0,
  kOk = 1,
  kLow = 2,
  kCritical = 3,
  kEmergency = 4,
  kFailed = 5,
  kUnhealthy = 6,
  kCharging = 7,
};

// Bits of SYS_STATUS's onboard_control_sensors_*.
struct MavSensor {
  static constexpr std::uint32_t kGyro = 1U << 0U;
  static constexpr std::uint32_t kAccelerometer = 1U << 1U;
  static constexpr std::uint32_t kMagnetometer = 1U << 2U;
  static constexpr std::uint32_t kPressure = 1U << 3U;
  static constexpr std::uint32_t kGps = 1U << 5U;
  static constexpr std::uint32_t kRcReceiver = 1U << 16U;
  static constexpr std::uint32_t kGeofence = 1U << 20U;
  static constexpr std::uint32_t kAhrs = 1U << 21U;
  static constexpr std::uint32_t kBattery = 1U << 25U;
  static constexpr std::uint32_t kPrearmCheck = 1U << 28U;
};

// Bits of AUTOPILOT_VERSION.capabilities.
struct MavCapability {
  static constexpr std::uint64_t kMissionInt = 4;
  static constexpr std::uint64_t kCommandInt = 8;
  static constexpr std::uint64_t kParamEncodeBytewise = 16;
  static constexpr std::uint64_t kFtp = 32;
  static constexpr std::uint64_t kSetPositionTargetGlobalInt = 256;
  static constexpr std::uint64_t kMavlink2 = 8192;
  static constexpr std::uint64_t kMissionFence = 16384;
  static constexpr std::uint64_t kMissionRally = 32768;
  static constexpr std::uint64_t kParamEncodeCCast = 131072;
};

// Bits of EKF_STATUS_REPORT.flags (ArduPilot) and of ESTIMATOR_STATUS.flags (PX4); the first eleven
// mean the same.
struct MavEstimatorFlag {
  static constexpr std::uint16_t kAttitude = 1;
  static constexpr std::uint16_t kVelocityHorizontal = 2;
  static constexpr std::uint16_t kVelocityVertical = 4;
  static constexpr std::uint16_t kPositionHorizontalRelative = 8;
  static constexpr std::uint16_t kPositionHorizontalAbsolute = 16;
  static constexpr std::uint16_t kPositionVerticalAbsolute = 32;
  static constexpr std::uint16_t kPositionVerticalAboveGround = 64;
  static constexpr std::uint16_t kConstantPositionMode = 128;
  static constexpr std::uint16_t kPredictedPositionHorizontalRelative = 256;
  static constexpr std::uint16_t kPredictedPositionHorizontalAbsolute = 512;
  static constexpr std::uint16_t kPx4GpsGlitch = 1024;
  static constexpr std::uint16_t kPx4AccelerometerError = 2048;
  static constexpr std::uint16_t kArduPilotUninitialized = 1024;
  static constexpr std::uint16_t kArduPilotGpsGlitching = 32768;
};

enum class MavCameraMode : std::uint8_t { kImage = 0, kVideo = 1, kImageSurvey = 2 };

// Bits of CAMERA_INFORMATION.flags.
struct MavCameraFlag {
  static constexpr std::uint32_t kCaptureVideo = 1;
  static constexpr std::uint32_t kCaptureImage = 2;
  static constexpr std::uint32_t kHasModes = 4;
};

enum class MavStorageStatus : std::uint8_t {
  kEmpty = 0,
  kUnformatted = 1,
  kReady = 2,
  kNotSupported = 3,
};

enum class MavMountMode : std::uint8_t {
  kRetract = 0,
  kNeutral = 1,
  kMavlinkTargeting = 2,
  kRcTargeting = 3,
  kGpsPoint = 4,
};

// Bits of GIMBAL_MANAGER_SET_PITCHYAW.flags, DO_GIMBAL_MANAGER_PITCHYAW's param5, and of the flags
// of GIMBAL_MANAGER_STATUS and GIMBAL_DEVICE_ATTITUDE_STATUS.
struct MavGimbalFlag {
  static constexpr std::uint32_t kRetract = 1;
  static constexpr std::uint32_t kNeutral = 2;
  static constexpr std::uint32_t kRollLock = 4;
  static constexpr std::uint32_t kPitchLock = 8;
  static constexpr std::uint32_t kYawLock = 16;  // yaw is from north; without, from the nose
  static constexpr std::uint32_t kYawInVehicleFrame = 32;
  static constexpr std::uint32_t kYawInEarthFrame = 64;
};

// Bits of GIMBAL_DEVICE_ATTITUDE_STATUS.failure_flags.
struct MavGimbalError {
  static constexpr std::uint32_t kAtRollLimit = 1;
  static constexpr std::uint32_t kAtPitchLimit = 2;
  static constexpr std::uint32_t kAtYawLimit = 4;
  static constexpr std::uint32_t kMotor = 32;
  static constexpr std::uint32_t kComms = 128;
};

// Bits of GIMBAL_MANAGER_INFORMATION.cap_flags.
struct MavGimbalCapability {
  static constexpr std::uint32_t kHasPitchAxis = 32;
  static constexpr std::uint32_t kHasPitchLock = 128;
  static constexpr std::uint32_t kHasYawAxis = 256;
  static constexpr std::uint32_t kHasYawFollow = 512;
  static constexpr std::uint32_t kHasYawLock = 1024;
};

// HEARTBEAT.custom_mode of ArduCopter.
enum class ArduCopterMode : std::uint32_t {
  kStabilize = 0,
  kAltHold = 2,
  kAuto = 3,
  kGuided = 4,
  kLoiter = 5,
  kRtl = 6,
  kLand = 9,
  kPosHold = 16,
  kBrake = 17,
  kSmartRtl = 21,
};

// HEARTBEAT.custom_mode of PX4: main mode << 16 | sub mode << 24.
enum class Px4MainMode : std::uint8_t {
  kNone = 0,
  kManual = 1,
  kAltitude = 2,
  kPosition = 3,
  kAuto = 4,
  kAcro = 5,
  kOffboard = 6,
  kStabilized = 7,
};
enum class Px4AutoMode : std::uint8_t {
  kNone = 0,
  kReady = 1,
  kTakeoff = 2,
  kHold = 3,
  kMission = 4,
  kReturn = 5,
  kLand = 6,
};

struct Px4Mode {
  Px4MainMode main = Px4MainMode::kNone;
  Px4AutoMode sub = Px4AutoMode::kNone;
  bool operator==(const Px4Mode&) const = default;
};

constexpr std::uint32_t ToCustomMode(Px4Mode mode) {
  return static_cast<std::uint32_t>(mode.main) << 16U | static_cast<std::uint32_t>(mode.sub) << 24U;
}
constexpr Px4Mode Px4ModeOf(std::uint32_t custom_mode) {
  return {static_cast<Px4MainMode>(custom_mode >> 16U & 0xFFU),
          static_cast<Px4AutoMode>(custom_mode >> 24U & 0xFFU)};
}

}  // namespace colmap_ext
