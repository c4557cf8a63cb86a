#include "session/flown_capture.h"

#include <signal.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <set>
#include <thread>

#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "session/simulated_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr double kPollS = 0.1;
constexpr double kDroneReadyS = 120;  // it makes its scene first
constexpr double kDaemonReadyS = 60;
constexpr double kVehicleReadyS = 120;  // its estimator
constexpr double kStuckS = 60;          // a simulated vehicle that nobody would resume
constexpr int kStartsWithoutPhoto = 3;
constexpr double kReturnAboveSiteM = 15;

int FreeUdpPort() {
  boost::asio::io_context io;
  boost::asio::ip::udp::socket socket(io, {boost::asio::ip::address_v4::loopback(), 0});
  return socket.local_endpoint().port();
}

void Sleep() { std::this_thread::sleep_for(std::chrono::duration<double>(kPollS)); }

std::string StateOf(const Json& status) { return status["state"].get<std::string>(); }
std::string ReasonOf(const Json& status) { return status["reason"].get<std::string>(); }

int CountStored(const Json& status) {
  int count = 0;
  for (const Json& view : status["views"]) count += view["status"] == "stored" ? 1 : 0;
  return count;
}

bool HasPendingView(const Json& status) {
  for (const Json& view : status["views"]) {
    if (view["status"] == "pending" || view["status"] == "asked") return true;
  }
  return false;
}

bool HasPictureOnItsWay(const Json& status) {
  for (const Json& view : status["views"]) {
    if (view["status"] == "captured") return status["fetching"].get<int>() > 0;
  }
  return false;
}

// Options of the drone that come from the session's own.
void WriteDroneIni(const StageOptions& options, const fs::path& path) {
  OptionSet set;
  SimulatedCameraOptions camera = options.simulation;
  RenderOptions render = options.render;
  BindOptions(set, &camera);
  BindOptions(set, &render);
  WriteFileAtomically(path, set.ToIni());
}

void WriteFlightIni(const StageOptions& options, const fs::path& path) {
  OptionSet set;
  FlightOptions flight = options.flight;
  BindOptions(set, &flight);
  WriteFileAtomically(path, set.ToIni());
}

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

FlownCapture::FlownCapture(const SessionInputs& inputs, const StageOptions& options,
                           const Workspace& workspace, double site_top_m, const JobControl& job)
    : inputs_(inputs),
      options_(options),
      workspace_(workspace),
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
  if (!fs::exists(workspace.images())) return;
  for (const std::string& name : ListPhotos(workspace.images())) earlier_photos_.insert(name);
}

FlownCapture::~FlownCapture() {
  // The daemon of a real vehicle stays when it still flies: its own rules bring it home.
  if (const auto running = FindDaemon(workspace_.root()); daemon_ && running) {
    kill(running->pid, SIGTERM);
    for (int i = 0; i < 30 && daemon_->IsRunning(); ++i) Sleep();
  }
}

std::string FlownCapture::PhotoName(int view_id) { return SimulatedSite::PhotoName(view_id); }

void FlownCapture::StartDrone(const JobControl& job) {
  job.Info("Starting the simulated drone");
  link_port_ = FreeUdpPort();
  int run = 0;
  while (fs::exists(workspace_.root() / "drone" / std::to_string(run))) ++run;
  drone_path_ = workspace_.root() / "drone" / std::to_string(run);
  const fs::path ini = workspace_.logs() / "drone.ini";
  WriteDroneIni(options_, ini);
  const bool is_px4 = options_.session.personality == "px4";
  const double return_m = std::ceil(site_top_m_ + kReturnAboveSiteM);
  const std::string parameters =
      is_px4 ? "RTL_RETURN_ALT=" + Number(return_m) : "RTL_ALT=" + Number(100 * return_m);
  std::vector<std::string> arguments = {FindSibling("colmap_ext_dronesim"),
                                        "--project_path",
                                        ini,
                                        "--output_path",
                                        drone_path_,
                                        "--personality",
                                        options_.session.personality,
                                        "--connection",
                                        "udpout://127.0.0.1:" + std::to_string(link_port_),
                                        "--speed",
                                        Number(options_.session.simulation_speed),
                                        "--full_resolution",
                                        options_.session.full_resolution ? "1" : "0",
                                        "--Drone.failsafes",
                                        "safe",
                                        "--Drone.parameters",
                                        parameters,
                                        "--Drone.gps_bias_m",
                                        Number(options_.simulation.gps_noise_m),
                                        "--Drone.gps_noise_m",
                                        Number(options_.simulation.gps_noise_m / 3)};
  if (!inputs_.scene.empty()) {
    arguments.insert(arguments.end(), {"--scene", inputs_.scene});
  } else {
    arguments.insert(arguments.end(), {"--scene_path", inputs_.scene_path});
  }
  drone_ = std::make_unique<ChildProgram>(arguments, workspace_.logs() / "drone.log");
  const Json ready = Json::parse(drone_->WaitForLine("{", kDroneReadyS), nullptr, false);
  if (!ready.is_object() || !ready.contains("http_port")) drone_->FailWithLastLine();
  drone_port_ = ready["http_port"].get<int>();
}

void FlownCapture::StartDaemon(const JobControl& job) {
  job.Info("Starting the flight daemon");
  const fs::path ini = workspace_.logs() / "flight.ini";
  WriteFlightIni(options_, ini);
  std::vector<std::string> arguments = {FindSibling("colmap_ext_flightd"), "--project_path", ini,
                                        "--workspace_path", workspace_.root()};
  const auto add = [&arguments](const std::string& name, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {"--" + name, value});
  };
  if (is_simulated_) {
    add("connection", "udpin://127.0.0.1:" + std::to_string(link_port_));
    add("simulated_speed", Number(options_.session.simulation_speed));
    add("picture_url", "http://127.0.0.1:" + std::to_string(drone_port_) +
                           "/pictures/{resolution}/img_{index5}.jpg");
  } else {
    add("connection", options_.session.vehicle);
    add("picture_url", inputs_.picture_url);
    add("capture_folder", inputs_.capture_folder);
  }
  daemon_ = std::make_unique<ChildProgram>(arguments, workspace_.logs() / "flightd.log");
  for (double waited_s = 0; waited_s < kDaemonReadyS; waited_s += kPollS) {
    if (!daemon_->IsRunning()) daemon_->FailWithLastLine();
    if (const auto address = FindDaemon(workspace_.root())) {
      client_.emplace(*address);
      return;
    }
    Sleep();
  }
  throw Error("the flight daemon is not ready after " + Number(kDaemonReadyS) + " s");
}

Json FlownCapture::WaitFor(const std::string& what,
                           const std::function<bool(const Json&)>& is_there, double timeout_s,
                           const JobControl& job) {
  for (double waited_s = 0; waited_s < timeout_s; waited_s += kPollS) {
    job.ThrowIfCancelled();
    if (drone_ && !drone_->IsRunning()) drone_->FailWithLastLine();
    Json status = client_->Status();
    if (is_there(status)) return status;
    Sleep();
  }
  const Json status = client_->Status();
  throw Error("waited " + Number(timeout_s) + " s for " + what + ": the daemon is in " +
              StateOf(status) + " (" + ReasonOf(status) + ")");
}

Json FlownCapture::WaitForVehicle(const JobControl& job) {
  return WaitFor(
      "the vehicle and its home position",
      [](const Json& status) {
        const std::string state = StateOf(status);
        return state != "DISCONNECTED" && state != "CONNECTED" &&
               status["vehicle"].contains("home") &&
               status["vehicle"].value("estimate_good", false);
      },
      kVehicleReadyS, job);
}

// The vehicle's battery is exchanged on the ground; a simulated one by its faults.
void FlownCapture::SwapBattery() const {
  if (!is_simulated_) return;
  FlightClient({drone_port_, 0, ""}).Post("/faults", Json::object({{"battery_percent", 100}}));
}

void FlownCapture::Begin(const FlightMission& mission, const Json& status) {
  const int revision = status["revision"].get<int>();
  const std::string state = StateOf(status);
  const bool is_in_the_air = state == "HOLD" || state == "FETCH";
  if (!is_in_the_air) {
    FlightMission loaded = mission;
    loaded.at_end = AtEnd::kHold;
    client_->Load(loaded);
    return;
  }
  Json changes = MissionToJson(mission);
  changes["revision"] = revision + 1;
  changes["at_end"] = "hold";
  client_->Append(changes);
}

// A real vehicle arms only after somebody typed yes.
void FlownCapture::AskPerson() const {
  const fs::path path = workspace_.root() / "flight" / "mission.json";
  const FlightMission mission = MissionFromJson(ReadJsonFile(path), path.string());
  const FlightOptions& flight = options_.flight;
  std::cout << ChecklistText(
                   MakeChecklist(mission, flight.percent_per_minute, flight.reserve_percent),
                   mission)
            << "The vehicle will arm and take off. Type yes to start: " << std::flush;
  std::string answer;
  std::getline(std::cin, answer);
  if (answer != "yes") throw Error("not started: the answer was not yes");
}

void FlownCapture::Start(const JobControl& job) {
  SwapBattery();
  if (!is_simulated_ && !inputs_.yes) AskPerson();
  job.Debug("starting");
  client_->Start();
}

void FlownCapture::Fly(const FlightTask& task, const std::function<void(int)>& while_flying,
                       const JobControl& job) {
  Json status = WaitForVehicle(job);
  FlightSite site = task.site;
  const Json& home = status["vehicle"]["home"];
  site.home = EnuFromGeo(*site.frame.origin,
                         {home["lat"].get<double>(), home["lon"].get<double>(),
                          home["amsl_m"].get<double>() + options_.flight_plan.undulation_m});
  FlightPath path;
  path.waypoints = task.waypoints;
  const FlightMission mission = PlanFlightMission(path, site, PhotoName, options_.flight_plan);
  Begin(mission, status);
  photos_at_start_ = CountStored(client_->Status());
  starts_without_photo_ = 0;
  last_state_.clear();
  while (true) {
    job.ThrowIfCancelled();
    if (drone_ && !drone_->IsRunning()) drone_->FailWithLastLine();
    if (daemon_ && !daemon_->IsRunning()) daemon_->FailWithLastLine();
    status = client_->Status();
    const int stored = CountStored(status);
    if (stored != last_stored_) TakeTruePoses(status);
    last_stored_ = stored;
    job.Progress("photos", static_cast<std::size_t>(stored), status["views"].size());
    if (!Follow(status, job)) break;
    while_flying(stored);
    Sleep();
  }
  TakeTruePoses(status);
}

bool FlownCapture::Follow(const Json& status, const JobControl& job) {
  const std::string state = StateOf(status);
  const std::string reason = ReasonOf(status);
  const bool is_new = state != last_state_;
  last_state_ = state;
  const bool is_pending = HasPendingView(status);
  if (!is_pending && !HasPictureOnItsWay(status)) {
    return !(state == "HOLD" || state == "DISARMED" || state == "IDENTIFIED" ||
             state == "PREFLIGHT");
  }
  if (!is_pending) return true;  // pictures are on their way
  if (state == "IDENTIFIED" || state == "DISARMED") {
    const int stored = CountStored(status);
    starts_without_photo_ = stored > photos_at_start_ ? 0 : starts_without_photo_ + 1;
    photos_at_start_ = stored;
    if (starts_without_photo_ > kStartsWithoutPhoto) {
      throw Error("the vehicle does not fly: " + reason);
    }
    if (starts_without_photo_ > 1) job.Warn("not flown: " + reason + "; trying again");
    Start(job);
    return true;
  }
  const bool needs_person = state == "PAUSED" || state == "PILOT_OVERRIDE" || state == "LINK_LOST";
  if (is_new) waiting_since_ = std::chrono::steady_clock::now();
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - waiting_since_;
  if (needs_person && is_simulated_ && waited.count() > kStuckS) {
    throw Error("the simulated flight is stuck in " + state + ": " + reason);
  }
  if (needs_person && is_new) {
    job.Warn("the flight waits in " + state + ": " + reason +
             " (`colmap_ext flight_client resume` goes on)");
  }
  return true;
}

void FlownCapture::Finish(const JobControl& job) {
  const std::string state = StateOf(client_->Status());
  if (state == "IDENTIFIED" || state == "DISARMED" || state == "PREFLIGHT") return;
  job.Info("Flying home");
  client_->Abort(false);
  WaitFor(
      "the landing", [](const Json& status) { return StateOf(status) == "DISARMED"; },
      is_simulated_ ? kVehicleReadyS + 600 / options_.session.simulation_speed : 1200, job);
}

// The drone's own word on where its pictures were taken, under the names of their photos.
void FlownCapture::TakeTruePoses(const Json& status) const {
  const fs::path path = drone_path_ / "true_poses.txt";
  if (!is_simulated_ || !fs::exists(path)) return;
  const auto true_pose = PoseOfPhoto(ReadTruePoses(path));
  std::vector<TruePose> poses;
  for (const Json& view : status["views"]) {
    if (!view.contains("index")) continue;
    char name[32];
    std::snprintf(name, sizeof name, "img_%05d.jpg", view["index"].get<int>());
    const auto pose = true_pose.find(name);
    if (pose == true_pose.end() || earlier_photos_.contains(view["photo"].get<std::string>()))
      continue;
    poses.push_back({view["photo"].get<std::string>(), pose->second});
  }
  UpdateTruePoses(poses, SimulatedSite::TruePosesPath(workspace_));
}

}  // namespace colmap_ext
