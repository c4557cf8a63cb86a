#include "session/flown_capture.h"

#include <signal.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <set>
#include <thread>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/file_lock.h"
#include "colmap_ext/util/files.h"
#include "session/flight_programs.h"
#include "session/flight_recovery.h"
#include "session/simulated_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kPollS = 0.2;
constexpr double kDroneReadyS = 180;  // it makes its scene first
constexpr double kDaemonReadyS = 60;
constexpr double kDaemonEndsS = 5;
constexpr double kVehicleReadyS = 120;  // its estimator
constexpr double kWayHomeS = 1200;      // of the vehicle's clock
constexpr double kStuckS = 60;          // a simulated vehicle that nobody would resume
constexpr double kResumeS = 2;          // until it is resumed, and again
constexpr int kStartsWithoutPhoto = 3;

void Sleep() { std::this_thread::sleep_for(std::chrono::duration<double>(kPollS)); }

std::string StateOf(const Json& status) { return status.at("state").get<std::string>(); }
std::string ReasonOf(const Json& status) { return status.at("reason").get<std::string>(); }

bool IsOneOf(const std::string& state, std::initializer_list<const char*> states) {
  return std::any_of(states.begin(), states.end(), [&](const char* each) { return state == each; });
}

bool IsOnGround(const std::string& state) {
  return IsOneOf(state, {"DISCONNECTED", "CONNECTED", "IDENTIFIED", "PREFLIGHT", "DISARMED"});
}

bool NeedsPerson(const std::string& state) {
  return IsOneOf(state, {"PAUSED", "PILOT_OVERRIDE", "LINK_LOST"});
}

int CountViews(const Json& status, std::initializer_list<const char*> of_status) {
  int count = 0;
  for (const Json& view : status.at("views")) {
    count += IsOneOf(view.at("status").get<std::string>(), of_status) ? 1 : 0;
  }
  return count;
}

bool HasPendingView(const Json& status) { return CountViews(status, {"pending", "asked"}) > 0; }

bool HasPictureOnItsWay(const Json& status) {
  return CountViews(status, {"captured"}) > 0 && status.at("fetching").get<int>() > 0;
}

}  // namespace

FlownCapture::FlownCapture(const SessionInputs& inputs, const StageOptions& options,
                           const Workspace& workspace, double site_top_m, const JobControl& job)
    : inputs_(inputs),
      options_(options),
      workspace_(workspace),
      job_(job),
      site_top_m_(site_top_m),
      is_simulated_(options.session.vehicle == "simulated") {
  fs::create_directories(workspace.logs());
  if (const auto running = FindDaemon(workspace.root()); running && !is_simulated_) {
    job.Info("Using the flight daemon that runs for this workspace");
    client_.emplace(*running);
  } else {
    if (is_simulated_) StartDrone(job);
    StartDaemon(job);
  }
  WaitForVehicle(job);
}

FlownCapture::~FlownCapture() {
  if (!daemon_ || !daemon_->IsRunning()) return;
  try {
    if (!is_simulated_ && client_ && !IsOnGround(StateOf(client_->Status()))) {
      job_.Warn("the vehicle is sent home before this ends");
      Finish(JobControl());
    }
  } catch (const std::exception& error) {
    job_.Warn(std::string("the vehicle is left to its own failsafes: ") + error.what());
  }
  if (const auto running = FindDaemon(workspace_.root())) kill(running->pid, SIGTERM);
  for (double waited_s = 0; waited_s < kDaemonEndsS && daemon_->IsRunning(); waited_s += kPollS) {
    Sleep();
  }
}

std::string FlownCapture::PhotoName(int view_id) { return SimulatedSite::PhotoName(view_id); }

void FlownCapture::StartDrone(const JobControl& job) {
  // The daemon of a killed session ends with it, but not at once.
  const fs::path lock = DaemonLockPath(workspace_.root());
  for (double waited_s = 0; FileLock::IsHeld(lock); waited_s += kPollS) {
    if (waited_s > kDaemonEndsS) {
      throw Error(workspace_.root().string() +
                  ": a flight daemon already flies for this workspace; end it first");
    }
    Sleep();
  }
  RecoverFromLastDrone(workspace_, options_.session.full_resolution, job);
  job.Info("Starting the simulated drone");
  link_port_ = FreeUdpPort();
  drone_ = std::make_unique<ChildProgram>(
      DroneArguments(inputs_, options_, workspace_, site_top_m_, link_port_, DronePath(workspace_)),
      workspace_.logs() / "drone.log");
  const Json ready = Json::parse(drone_->WaitForLine("{", kDroneReadyS, job), nullptr, false);
  if (!ready.is_object() || !ready.contains("http_port")) drone_->FailWithLastLine();
  drone_port_ = ready.at("http_port").get<int>();
}

void FlownCapture::StartDaemon(const JobControl& job) {
  job.Info("Starting the flight daemon");
  std::error_code ignored;
  fs::remove(DaemonAddressPath(workspace_.root()), ignored);  // of one that was killed
  daemon_ = std::make_unique<ChildProgram>(
      is_simulated_ ? SimulationDaemonArguments(options_, workspace_, link_port_, drone_port_)
                    : VehicleDaemonArguments(inputs_, options_, workspace_),
      workspace_.logs() / "flightd.log");
  for (double waited_s = 0; waited_s < kDaemonReadyS; waited_s += kPollS) {
    job.ThrowIfCancelled();
    RequireChildren();
    if (const auto address = FindDaemon(workspace_.root())) {
      client_.emplace(*address);
      return;
    }
    Sleep();
  }
  throw Error("the flight daemon is not ready after a minute; what it said: " +
              (workspace_.logs() / "flightd.log").string());
}

void FlownCapture::RequireChildren() const {
  if (drone_ && !drone_->IsRunning()) drone_->FailWithLastLine();
  if (daemon_ && !daemon_->IsRunning()) daemon_->FailWithLastLine();
}

Json FlownCapture::Status() const {
  RequireChildren();
  try {
    return client_->Status();
  } catch (const Error&) {
    Sleep();
    RequireChildren();  // knows better why
    throw;
  }
}

Json FlownCapture::WaitFor(const std::string& what,
                           const std::function<bool(const Json&)>& is_there, double timeout_s,
                           const JobControl& job) {
  for (double waited_s = 0; waited_s < timeout_s; waited_s += kPollS) {
    job.ThrowIfCancelled();
    Json status = Status();
    if (is_there(status)) return status;
    Sleep();
  }
  const Json status = Status();
  throw Error("waited " + std::to_string(static_cast<int>(timeout_s)) + " s for " + what +
              ": the daemon is in " + StateOf(status) + " (" + ReasonOf(status) + ")");
}

Json FlownCapture::WaitForVehicle(const JobControl& job) {
  return WaitFor(
      "the vehicle and its home position",
      [this](const Json& status) {
        return !IsOneOf(StateOf(status), {"DISCONNECTED", "CONNECTED"}) &&
               status.at("vehicle").contains("home") &&
               status.at("vehicle").value("estimate_good", !is_simulated_);
      },
      kVehicleReadyS, job);
}

// A daemon of its own flies on when the session ends: what it was told before comes first.
Json FlownCapture::WaitForOlderFlight(const JobControl& job) {
  bool is_told = false;
  while (true) {
    job.ThrowIfCancelled();
    Json status = Status();
    const std::string state = StateOf(status);
    if (IsOnGround(state) || state == "HOLD") return status;
    if (!is_told) job.Info("Waiting for the end of the flight that the daemon is on");
    is_told = true;
    WarnWhereItWaits(status, job);
    Sleep();
  }
}

// The vehicle's battery is exchanged on the ground; a simulated one by its faults.
void FlownCapture::SwapBattery() const {
  if (!is_simulated_) return;
  FlightClient({drone_port_, 0, ""}).Post("/faults", Json::object({{"battery_percent", 100}}));
}

void FlownCapture::Begin(FlightMission mission, const Json& status) {
  mission.at_end = AtEnd::kHold;
  mission_ = mission;
  if (IsOnGround(StateOf(status))) {
    client_->Load(mission);
    return;
  }
  Json changes = MissionToJson(mission);
  changes["revision"] = status.at("revision").get<int>() + 1;
  client_->Append(changes);
}

// A real vehicle arms only after a person agreed to what it will do.
void FlownCapture::AskPerson(const Json& status) const {
  if (is_simulated_ || inputs_.yes) return;
  FlightMission left = mission_;
  std::set<int> done;
  for (const Json& view : status.at("views")) {
    if (!IsOneOf(view.at("status").get<std::string>(), {"pending", "asked"})) {
      done.insert(view.at("view_id").get<int>());
    }
  }
  for (FlightStop& stop : left.stops) {
    if (done.contains(stop.view_id)) stop.view_id = -1;
  }
  const FlightOptions& flight = options_.flight;
  const std::string checklist =
      ChecklistText(MakeChecklist(left, flight.percent_per_minute, flight.reserve_percent), left);
  if (!inputs_.confirm || !inputs_.confirm(checklist)) {
    throw Error("not started: nobody said yes (--yes starts without asking)");
  }
}

void FlownCapture::Start(const Json& status, const JobControl& job) {
  SwapBattery();
  AskPerson(status);
  job.Debug("starting");
  client_->Start();
}

void FlownCapture::Fly(const FlightTask& task, const std::function<void(int)>& while_flying,
                       const JobControl& job) {
  WaitForVehicle(job);
  Json status = WaitForOlderFlight(job);
  FlightPath path;
  int missing = 0;
  for (Waypoint waypoint : task.waypoints) {
    const bool is_there =
        waypoint.view_id >= 0 && fs::exists(workspace_.images() / PhotoName(waypoint.view_id));
    if (is_there) waypoint.view_id = -1;
    missing += waypoint.view_id >= 0 ? 1 : 0;
    path.waypoints.push_back(waypoint);
  }
  if (missing == 0) return;
  FlightSite site = task.site;
  const Json& home = status.at("vehicle").at("home");
  site.home = EnuFromGeo(*site.frame.origin,
                         {home.at("lat").get<double>(), home.at("lon").get<double>(),
                          home.at("amsl_m").get<double>() + options_.flight_plan.undulation_m});
  Begin(PlanFlightMission(path, site, PhotoName, options_.flight_plan), status);
  photos_at_start_ = CountViews(Status(), {"stored"});
  starts_without_photo_ = 0;
  last_state_.clear();
  int last_stored = -1;
  do {
    job.ThrowIfCancelled();
    status = Status();
    const int stored = CountViews(status, {"stored"});
    if (stored != last_stored) TakePoses(status);
    last_stored = stored;
    job.Progress("photos", static_cast<std::size_t>(stored), status.at("views").size());
    while_flying(stored);
    Sleep();
  } while (Follow(status, job));
  TakePoses(status);
  WarnOfMissingPhotos(status, job);
}

bool FlownCapture::Follow(const Json& status, const JobControl& job) {
  const std::string state = StateOf(status);
  if (!HasPendingView(status)) {
    WarnWhereItWaits(status, job);
    const bool is_idle = IsOneOf(state, {"HOLD", "DISARMED", "IDENTIFIED", "PREFLIGHT"});
    return !is_idle || HasPictureOnItsWay(status);
  }
  if (IsOneOf(state, {"IDENTIFIED", "DISARMED"})) {
    const int stored = CountViews(status, {"stored"});
    starts_without_photo_ = stored > photos_at_start_ ? 0 : starts_without_photo_ + 1;
    photos_at_start_ = stored;
    if (starts_without_photo_ > kStartsWithoutPhoto) {
      throw Error("the vehicle does not fly: " + ReasonOf(status));
    }
    if (starts_without_photo_ > 1) {
      job.Warn("not flown: " + ReasonOf(status) + "; trying again");
    }
    Start(status, job);
    return true;
  }
  WarnWhereItWaits(status, job);
  return true;
}

void FlownCapture::WarnWhereItWaits(const Json& status, const JobControl& job) {
  const std::string state = StateOf(status);
  const bool is_new = state != last_state_;
  last_state_ = state;
  if (is_new) {
    waiting_since_ = std::chrono::steady_clock::now();
    resumes_ = 0;
  }
  if (!NeedsPerson(state)) return;
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - waiting_since_;
  if (is_simulated_ && waited.count() > kStuckS) {
    throw Error("the simulated flight is stuck in " + state + ": " + ReasonOf(status));
  }
  if (is_simulated_ && state != "LINK_LOST") {
    ResumeSimulation(waited.count(), job);
  } else if (is_new) {
    job.Warn("the flight waits in " + state + ": " + ReasonOf(status) +
             " (`colmap_ext flight_client resume` goes on)");
  }
}

// Nobody stands by a simulated drone: it is resumed when it waits for a person. That happens when
// this computer is so busy that its heartbeats come too late for its accelerated clock.
void FlownCapture::ResumeSimulation(double waited_s, const JobControl& job) {
  if (waited_s < kResumeS * (resumes_ + 1)) return;
  ++resumes_;
  try {
    client_->Resume();
    job.Warn("the simulated flight was interrupted, and is resumed");
  } catch (const Error& error) {
    job.Debug(error.what());  // on the ground, it starts again
  }
}

void FlownCapture::Finish(const JobControl& job) {
  const std::string state = StateOf(Status());
  if (IsOnGround(state)) return;
  job.Info("Flying home");
  if (is_simulated_ && state == "PILOT_OVERRIDE") client_->Resume();
  client_->Abort(false);
  const double speed = is_simulated_ ? options_.session.simulation_speed : 1;
  WaitFor(
      "the landing", [](const Json& status) { return StateOf(status) == "DISARMED"; },
      30 + kWayHomeS / speed, job);
}

void FlownCapture::WarnOfMissingPhotos(const Json& status, const JobControl& job) const {
  for (const Json& view : status.at("views")) {
    const std::string view_status = view.at("status").get<std::string>();
    if (view_status == "stored") continue;
    const std::string photo = view.at("photo").get<std::string>();
    if (fs::exists(workspace_.images() / photo)) continue;
    job.Warn(photo + " was not taken: " + view.value("reason", "its file did not arrive"));
  }
}

// The drone's own word on where its pictures were taken, under the names of their photos.
void FlownCapture::TakePoses(const Json& status) const {
  if (!is_simulated_) return;
  std::map<std::string, int> index_of_photo;
  for (const Json& view : status.at("views")) {
    const int index = view.value("index", -1);
    if (index >= 0) index_of_photo[view.at("photo").get<std::string>()] = index;
  }
  TakeTruePoses(index_of_photo, workspace_);
}

}  // namespace colmap_ext
