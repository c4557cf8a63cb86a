// What people and the planner ask for.
#include <algorithm>

#include "flight/machine_impl.h"

namespace colmap_ext {
namespace {

FlightReply Refuse(const std::string& why) { return {false, why}; }

}  // namespace

FlightReply MachineImpl::Request(const FlightRequest& request) {
  if (is_shadow) return Refuse("shadow mode: this daemon only watches");
  switch (request.kind) {
    case FlightRequest::Kind::kLoad:
      return Load(request);
    case FlightRequest::Kind::kAppend:
      return Append(request);
    case FlightRequest::Kind::kPreflight:
      return Preflight();
    case FlightRequest::Kind::kStart:
      return Start();
    case FlightRequest::Kind::kPause:
      return Pause();
    case FlightRequest::Kind::kResume:
      return Resume();
    case FlightRequest::Kind::kAbort:
      break;
  }
  return Abort(request.land);
}

void MachineImpl::TakeSurface(const FlightRequest& request) {
  surface_ = request.surface;
  surface_top_z_m_ = request.surface_top_z_m;
}

FlightReply MachineImpl::Load(const FlightRequest& request) {
  // The mission of a flight that this daemon did not see: it is needed to go on.
  const bool is_restored = state == FlightState::kPaused && !has_mission_;
  if (IsFlying() && !is_restored) {
    return Refuse(std::string("in ") + Name(state) + " views can only be appended");
  }
  const std::string complaint = request.mission.Check();
  if (!complaint.empty()) return Refuse(complaint);
  mission = request.mission;
  TakeSurface(request);
  has_mission_ = true;
  is_preflight_fresh_ = false;
  items.clear();
  for (const FlightStop& stop : mission.stops) {
    if (stop.view_id < 0) continue;
    ViewEntry& entry = ledger.views[stop.view_id];
    if (entry.photo.empty()) entry.photo = stop.photo;
    if (entry.status == ViewStatus::kFailed) {
      Record({{"type", "retry"}, {"view", stop.view_id}});
    }
  }
  next_stop = NextPendingStop(0);
  came_from_stop_ = false;
  FetchWhatIsCaptured();
  return {};
}

FlightReply MachineImpl::Append(const FlightRequest& request) {
  if (!has_mission_) return Refuse("there is no mission to append to; load one");
  if (request.mission.revision != mission.revision + 1) {
    return Refuse("the mission is at revision " + std::to_string(mission.revision) +
                  "; an append must name the next one");
  }
  FlightMission longer = request.mission;
  longer.stops = mission.stops;
  longer.stops.insert(longer.stops.end(), request.stops.begin(), request.stops.end());
  const std::string complaint = longer.Check();
  if (!complaint.empty()) return Refuse(complaint);
  mission = std::move(longer);
  TakeSurface(request);
  for (const FlightStop& stop : request.stops) {
    if (stop.view_id >= 0) ledger.views[stop.view_id].photo = stop.photo;
  }
  is_preflight_fresh_ = false;
  if (!IsFlying()) next_stop = NextPendingStop(next_stop);
  if (state == FlightState::kHold || state == FlightState::kFetch) {
    if (NextPendingStop(next_stop) < static_cast<int>(mission.stops.size())) {
      BeginStop();
    } else {
      Enter(FlightState::kFetch, "the mission is at its end");
    }
  }
  return {};
}

FlightReply MachineImpl::Preflight() {
  if (!has_mission_) return Refuse("there is no mission; load one");
  const bool is_ready = state == FlightState::kIdentified || state == FlightState::kPreflight ||
                        state == FlightState::kDisarmed;
  if (!is_ready) return Refuse(std::string("not in ") + Name(state));
  is_preflight_fresh_ = false;
  Enter(FlightState::kPreflight, "checking");
  Send(CommandKind::kPreflight);
  AskCamera();
  return {};
}

FlightReply MachineImpl::Start() {
  const FlightReply reply = Preflight();
  if (!reply.is_accepted) return reply;
  next_stop = NextPendingStop(0);
  if (next_stop == static_cast<int>(mission.stops.size())) {
    Enter(FlightState::kIdentified, "every view of the mission has its picture");
    return Refuse("every view of the mission has its picture; nothing to fly");
  }
  TakeUnreported();
  start_wanted_ = true;
  return {};
}

FlightReply MachineImpl::Pause() {
  if (state == FlightState::kPreflight && start_wanted_) {
    start_wanted_ = false;
    Enter(FlightState::kIdentified, "start was called off");
    return {};
  }
  if (state == FlightState::kPilotOverride || state == FlightState::kLinkLost) {
    return Refuse(std::string("in ") + Name(state) + " the daemon does not command");
  }
  if (!IsFlying()) return Refuse("the vehicle does not fly");
  if (state == FlightState::kPaused && pause_cause_ != PauseCause::kFoundFlying) {
    pause_cause_ = PauseCause::kRequested;  // also ends a pause that would end by itself
    is_resuming_ = false;
    return {};
  }
  StopHere(PauseCause::kRequested, "asked for");
  return {};
}

FlightReply MachineImpl::Resume() {
  if (state != FlightState::kPaused && state != FlightState::kPilotOverride) {
    return Refuse(std::string("in ") + Name(state) + " there is nothing to resume");
  }
  if (!has_mission_) return Refuse("the mission is not known; load it first");
  if (vehicle_.landed == LandedState::kOnGround) {
    return Refuse("the vehicle stands on the ground; start when it is disarmed");
  }
  if (!IsPositionGood()) return Refuse("the position is not reliable");
  is_resuming_ = true;
  Record({{"type", "resume"}});
  Expect({VehicleMode::kGuided});
  Send(CommandKind::kGuided);
  return {};
}

FlightReply MachineImpl::Abort(bool land) {
  if (state == FlightState::kPilotOverride) {
    return Refuse("the pilot has the vehicle: resume first");
  }
  if (state == FlightState::kLinkLost) return Refuse("the vehicle cannot be reached");
  if (!IsFlying()) {
    start_wanted_ = false;
    if (state == FlightState::kPreflight) Enter(FlightState::kIdentified, "start was called off");
    return {};
  }
  is_resuming_ = false;
  if (land) {
    BeginLanding("asked for");
  } else {
    BeginReturn("asked for");
  }
  return {};
}

// Files of pictures that were taken but not fetched, by this run or one before.
void MachineImpl::FetchWhatIsCaptured() {
  for (const auto& [view_id, entry] : ledger.views) {
    if (entry.status == ViewStatus::kCaptured) Fetch(view_id, false);
    const bool lacks_full = entry.status == ViewStatus::kStored && mission.full_resolution &&
                            !entry.full_stored && entry.capture.record.index >= 0;
    if (lacks_full) Fetch(view_id, true);
  }
}

}  // namespace colmap_ext
