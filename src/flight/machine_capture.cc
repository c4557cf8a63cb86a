// Pictures: asking for one, and accounting for each exactly once.
#include <algorithm>
#include <limits>

#include "flight/machine_impl.h"

namespace colmap_ext {
namespace {

constexpr double kCameraAnswerS = 4;
constexpr int kMaxMissed = 20;  // pictures in a row that were never reported

}  // namespace

void MachineImpl::BeginCapture() {
  capture_attempts_ = 0;
  Enter(FlightState::kCapture, reason);
  AskForPicture();
}

void MachineImpl::AskForPicture() {
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  ++capture_attempts_;
  capture_sent_s_ = now_s;
  retry_at_s_ = -1;
  camera_asked_s_ = -1;
  was_counted_ = false;
  FlightCommand command;
  command.kind = CommandKind::kCapture;
  command.sequence = ledger.next_sequence;
  Record({{"type", "ask"},
          {"view", stop.view_id},
          {"photo", stop.photo},
          {"sequence", command.sequence},
          {"after_index", ledger.last_index}});
  Send(command);
}

void MachineImpl::AdvanceCapture() {
  if (IsDone(next_stop)) {
    FinishStop();
    return;
  }
  if (retry_at_s_ >= 0) {
    if (now_s < retry_at_s_) return;
    if (!TakeUnreported()) AskForPicture();
    return;
  }
  const AwaitedCommand& command = Last(CommandKind::kCapture);
  if (command.outcome == CommandOutcome::kRejected) {
    NextAttempt("the camera refuses: " + command.text);
    return;
  }
  if (now_s - capture_sent_s_ < options.capture_timeout_s) return;
  if (camera_asked_s_ < 0) {
    AskCamera();
    return;
  }
  if (now_s - camera_asked_s_ < kCameraAnswerS) return;
  if (TakeUnreported()) return;
  NextAttempt("the camera does not report a picture");
}

// How many pictures the camera has, and, while a view waits for one, the reports of the new ones.
void MachineImpl::AskCamera() {
  camera_asked_s_ = now_s;
  FlightCommand ask;
  ask.kind = CommandKind::kAskCamera;
  ask.after_index = IsWaitingForPicture() ? ledger.last_index : std::numeric_limits<int>::max();
  Send(ask);
}

bool MachineImpl::IsWaitingForPicture() const {
  const std::optional<int> asked = AskedView();
  return asked && ledger.views.at(*asked).status == ViewStatus::kAsked;
}

// A picture that the camera counts and nothing describes was taken where the vehicle is, if it has
// not left the view since.
bool MachineImpl::TakeUnreported() {
  if (!was_counted_ || counted_index_ <= ledger.last_index || !IsWaitingForPicture()) return false;
  was_counted_ = false;
  TakeReport(IsAtView(*AskedView()) ? *AskedView() : -1, OwnReport(counted_index_));
  return true;
}

bool MachineImpl::IsAtView(int view_id) const {
  for (const FlightStop& stop : mission.stops) {
    if (stop.view_id != view_id || !vehicle_.position) continue;
    return (Position() - stop.position).norm() < 2 * options.settle_distance_m;
  }
  return false;
}

// A picture that was asked for before the link or the daemon was lost, and of which the camera
// tells no more than that it has it.
void MachineImpl::SettleLatePicture() {
  const bool is_late =
      was_counted_ && state != FlightState::kCapture && now_s - counted_s_ > kCameraAnswerS;
  if (is_late) TakeUnreported();
}

// Not before the camera had time to say that the last attempt did take a picture: a refusal may be
// of a repeated packet.
void MachineImpl::NextAttempt(const std::string& why) {
  if (capture_attempts_ < options.capture_attempts) {
    retry_at_s_ = now_s + options.capture_retry_s;
    if (camera_asked_s_ < 0) AskCamera();
    return;
  }
  GiveUpStop(why);
  BeginStop();
}

// The view that waits for the picture of the last order to the camera, also when it was given up
// since: a late report still belongs to it.
std::optional<int> MachineImpl::AskedView() const {
  std::optional<int> asked;
  int sequence = 0;
  for (const auto& [view_id, entry] : ledger.views) {
    const bool is_open = entry.status == ViewStatus::kAsked || entry.status == ViewStatus::kFailed;
    if (!is_open || entry.sequence <= sequence) continue;
    sequence = entry.sequence;
    asked = view_id;
  }
  // Only the very last order: an older one whose picture never came has none.
  if (sequence + 1 != ledger.next_sequence) return std::nullopt;
  return asked;
}

// The same index and time: MAVLink repeats reports.
bool MachineImpl::IsKnown(const CaptureReport& report) const {
  const auto is_same = [&](const CaptureReport& other) {
    return other.record.index == report.record.index &&
           (other.record.time == report.record.time || report.record.time.empty() ||
            other.record.time.empty());
  };
  for (const auto& [view_id, entry] : ledger.views) {
    const bool has_picture =
        entry.status == ViewStatus::kCaptured || entry.status == ViewStatus::kStored;
    if (has_picture && is_same(entry.capture)) return true;
  }
  const auto other = ledger.others.find(report.record.index);
  return other != ledger.others.end() && is_same(other->second);
}

void MachineImpl::OnCapture(const CaptureReport& report) {
  if (IsKnown(report)) return;
  const std::optional<int> asked = AskedView();
  if (!report.succeeded) {
    if (state == FlightState::kCapture && asked && retry_at_s_ < 0) {
      NextAttempt("the camera reports a failure");
    }
    return;
  }
  TakeReport(asked.value_or(-1), report);
}

void MachineImpl::TakeReport(int view_id, const CaptureReport& report) {
  // Pictures between the last one known and this one exist, and were never reported.
  const int first = std::max(ledger.last_index + 1, report.record.index - kMaxMissed);
  for (int index = first; knows_count_ && index < report.record.index; ++index) {
    Record(CaptureToJson(-1, OwnReport(index)));
  }
  Record(CaptureToJson(view_id, report));
  if (view_id < 0) return;
  Fetch(view_id, false);
}

void MachineImpl::OnPictureCount(int count) {
  const int index = count - 1;
  knows_count_ = true;
  if (IsWaitingForPicture()) {
    was_counted_ = true;
    counted_s_ = now_s;
    counted_index_ = index;
    return;
  }
  if (IsFlying()) return;
  // Another camera, or the same one after it was switched off.
  const bool is_new = is_first_count_ && index < ledger.last_index;
  is_first_count_ = false;
  if (is_new) Record({{"type", "new_camera"}});
  // What the camera holds from before is not ours.
  ledger.last_index = index;
}

// What is known here about a picture that the camera has but does not describe.
CaptureReport MachineImpl::OwnReport(int index) const {
  CaptureReport report;
  report.record.index = index;
  report.record.position = *vehicle_.position;
  report.record.sigma_horizontal_m = vehicle_.sigma_horizontal_m;
  report.record.sigma_vertical_m = vehicle_.sigma_vertical_m;
  const FlightStop& stop = mission.stops[static_cast<std::size_t>(next_stop)];
  const ViewDirection direction = {
      vehicle_.yaw_rad, vehicle_.gimbal ? vehicle_.gimbal->pitch_rad : stop.direction.pitch_rad};
  report.record.cam_from_enu = CamFromWorld(Eigen::Vector3d::Zero(), direction).rotation;
  report.relative_height_m = vehicle_.relative_height_m;
  report.ellipsoid_height_m = vehicle_.ellipsoid_height_m;
  report.body_yaw_rad = vehicle_.yaw_rad;
  report.gps_fix = vehicle_.gps_fix;
  return report;
}

void MachineImpl::Fetch(int view_id, bool full_resolution) {
  if (!fetching_.insert({view_id, full_resolution}).second) return;
  const ViewEntry& entry = ledger.views.at(view_id);
  output.fetches.push_back({view_id, entry.photo, entry.capture, full_resolution});
}

bool MachineImpl::IsFetchingLow() const {
  return std::any_of(fetching_.begin(), fetching_.end(),
                     [](const auto& fetch) { return !fetch.second; });
}

void MachineImpl::OnStored(int view_id, bool full_resolution, const std::string& file,
                           const std::string& sha256) {
  fetching_.erase({view_id, full_resolution});
  Record({{"type", "stored"},
          {"view", view_id},
          {"resolution", full_resolution ? "full" : "low"},
          {"file", file},
          {"sha256", sha256}});
  if (!full_resolution && mission.full_resolution) Fetch(view_id, true);
}

void MachineImpl::OnFetchFailed(int view_id, bool full_resolution, const std::string& why) {
  fetching_.erase({view_id, full_resolution});
  Record({{"type", "fetch_failed"},
          {"view", view_id},
          {"resolution", full_resolution ? "full" : "low"},
          {"reason", why}});
}

}  // namespace colmap_ext
