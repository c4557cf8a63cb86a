#include "colmap_ext/flight/flight_daemon.h"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <deque>
#include <iterator>
#include <random>
#include <utility>

#include "colmap_ext/flight/flight_client.h"
#include "colmap_ext/flight/flight_controller.h"
#include "colmap_ext/flight/flight_journal.h"
#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/mavlink/link_statistics.h"
#include "colmap_ext/mavlink/signing.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/file_lock.h"
#include "colmap_ext/util/files.h"
#include "flight/api_call.h"
#include "flight/api_server.h"
#include "flight/daemon_clock.h"
#include "flight/fetch_queue.h"
#include "flight/picture_store.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;

constexpr double kTickS = 0.1;       // of the daemon's clock, ...
constexpr double kMinTickS = 0.01;   // ... but not oftener than this of the wall's
constexpr double kMaxDelayS = 0.25;  // of records that nothing waits for

double WallS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double UnixS() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string MakeToken() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 8; ++i) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(random()));
    token += digits;
  }
  return token;
}

// Everything that the daemon holds. All methods run in the thread of the event loop.
class Daemon {
 public:
  Daemon(const DaemonOptions& options, const JobControl& job);
  ~Daemon();
  void Run();

 private:
  void StartSigning();
  void StartLink();
  void RestoreMission();
  void OnBytes(std::span<const std::uint8_t> bytes, bool ends_datagram);
  void OnFrame(const MavFrame& frame);
  void ScheduleTick();
  void PollFtp();
  FlightReply OnRequest(const FlightRequest& request);
  void HandleOutput();
  void WriteThenSend(std::vector<Json> records, std::vector<MavFrame> commands);
  void OnWritten(const std::string& problem);
  void Send(const std::vector<MavFrame>& frames);
  Json Status();

  const DaemonOptions& options_;
  const JobControl& job_;
  Workspace workspace_;
  FlightJournal journal_;
  FlightController controller_;
  DaemonClock clock_;
  asio::io_context io_;
  asio::thread_pool disk_{1};     // journal, in order
  asio::thread_pool workers_{2};  // surfaces and pictures
  asio::steady_timer timer_{io_};
  MavParser parser_;
  MavLinkStatistics statistics_;
  std::optional<MavSigning> signing_;
  std::unique_ptr<MavLink> link_;
  std::unique_ptr<FetchQueue> fetches_;
  std::unique_ptr<ApiServer> server_;
  std::string token_ = MakeToken();
  // Commands that wait for their records, by batch, oldest first.
  std::deque<std::vector<MavFrame>> waiting_;
  std::vector<Json> delayed_;  // records that nothing waits for
  double delayed_since_s_ = 0;
  int vehicle_system_ = 0;
  std::string fatal_;
};

Daemon::Daemon(const DaemonOptions& options, const JobControl& job)
    : options_(options),
      job_(job),
      workspace_(options.workspace_path),
      journal_(workspace_.root() / "flight" / "journal.jsonl"),
      controller_(options.flight, options.driver, journal_.ledger()),
      clock_(options.simulated_speed) {
  FetchQueue::Events events;
  events.stored = [this](const FetchRequest& request, const std::string& sha256) {
    controller_.OnStored(request.view_id, request.full_resolution, request.photo, sha256,
                         clock_.Now(WallS()));
    HandleOutput();
  };
  events.failed = [this](const FetchRequest& request, const std::string& reason) {
    controller_.OnFetchFailed(request.view_id, request.full_resolution, reason,
                              clock_.Now(WallS()));
    HandleOutput();
  };
  fetches_ = std::make_unique<FetchQueue>(&io_, &workers_, options, std::move(events));
  StartSigning();
  RestoreMission();
  StartLink();
  ApiBackend backend;
  backend.status = [this] { return Status(); };
  backend.request = [this](const FlightRequest& request) { return OnRequest(request); };
  backend.mission = [this]() -> const FlightMission& { return controller_.machine().mission(); };
  server_ =
      std::make_unique<ApiServer>(&io_, &workers_, options.api_port, token_, std::move(backend));
  WriteDaemonAddress({server_->port(), static_cast<int>(getpid()), token_}, workspace_.root());
}

Daemon::~Daemon() {
  fetches_->Stop();
  link_.reset();
  if (!delayed_.empty()) WriteThenSend({}, {});
  disk_.join();
  workers_.stop();
  workers_.join();
  std::error_code ignored;
  fs::remove(DaemonAddressPath(workspace_.root()), ignored);
}

void Daemon::StartSigning() {
  if (options_.signing_key_file.empty()) return;
  const fs::path state_path = workspace_.root() / "flight" / "signing.json";
  signing_.emplace(ReadMavSigningKey(options_.signing_key_file), MavSigningOptions(),
                   ReadMavSigningState(state_path), [state_path](const MavSigningState& state) {
                     WriteMavSigningState(state_path, state);
                   });
}

void Daemon::StartLink() {
  link_ = std::make_unique<MavLink>(&io_, ParseMavLinkUrl(options_.connection));
  MavLinkEvents events;
  events.receive = [this](std::span<const std::uint8_t> bytes, bool ends_datagram) {
    OnBytes(bytes, ends_datagram);
  };
  events.changed = [this](bool is_open, const std::string& reason) {
    job_.Info(is_open ? "link open" : "link lost: " + reason);
  };
  link_->Start(std::move(events));
}

// The mission of a run before, so that a flight can be resumed.
void Daemon::RestoreMission() {
  const fs::path path = workspace_.root() / "flight" / "mission.json";
  if (!fs::exists(path)) return;
  FlightRequest request;
  request.kind = FlightRequest::Kind::kLoad;
  request.mission = MissionFromJson(ReadJsonFile(path), path.string());
  if (!request.mission.surface_path.empty()) LoadSurface(&request);
  const FlightReply reply = controller_.Request(request, clock_.Now(WallS()));
  if (!reply.is_accepted) job_.Warn("the last mission is not restored: " + reply.reason);
}

void Daemon::OnBytes(std::span<const std::uint8_t> bytes, bool ends_datagram) {
  const auto take = [this](const MavFrame& frame) { OnFrame(frame); };
  parser_.Feed(bytes, take);
  if (ends_datagram) parser_.EndOfDatagram(take);
  HandleOutput();
}

void Daemon::OnFrame(const MavFrame& frame) {
  const double wall_s = WallS();
  if (signing_ && signing_->Check(frame, UnixS()) != MavSignatureVerdict::kAccepted) return;
  if (frame.system_id == options_.driver.system_id) return;
  statistics_.Received(frame, wall_s);
  if (const auto position = UnpackMav<MavGlobalPositionInt>(frame)) {
    clock_.OnVehicleTime(1e-3 * position->time_boot_ms, wall_s);
  }
  const double now_s = clock_.Now(wall_s);
  controller_.Receive(frame, now_s);
  if (controller_.vehicle().heard_s == now_s) vehicle_system_ = frame.system_id;
  if (frame.message_id == MavFileTransferProtocol::kId) {
    fetches_->Receive(frame, now_s);
    PollFtp();
  }
}

void Daemon::PollFtp() {
  const double now_s = clock_.Now(WallS());
  const bool is_heard = now_s - controller_.vehicle().heard_s < options_.flight.link_timeout_s;
  for (const MavFileTransferProtocol& message :
       fetches_->PollFtp(vehicle_system_, is_heard, now_s)) {
    controller_.Send(message, now_s);
  }
}

void Daemon::ScheduleTick() {
  const double speed = options_.simulated_speed > 0 ? options_.simulated_speed : 1;
  timer_.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(std::max(kTickS / speed, kMinTickS))));
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    if (job_.IsCancelled() || !fatal_.empty()) {
      io_.stop();
      return;
    }
    controller_.Tick(clock_.Now(WallS()));
    PollFtp();
    HandleOutput();
    if (!delayed_.empty() && WallS() - delayed_since_s_ > kMaxDelayS) WriteThenSend({}, {});
    ScheduleTick();
  });
}

FlightReply Daemon::OnRequest(const FlightRequest& request) {
  FlightReply reply = controller_.Request(request, clock_.Now(WallS()));
  const bool changes_mission =
      request.kind == FlightRequest::Kind::kLoad || request.kind == FlightRequest::Kind::kAppend;
  if (reply.is_accepted && changes_mission) {
    fetches_->SetMission(controller_.machine().mission());
    asio::post(disk_, [json = MissionToJson(controller_.machine().mission()),
                       path = workspace_.root() / "flight" / "mission.json", this] {
      try {
        WriteJsonFile(json, path);
      } catch (const std::exception& error) {
        asio::post(io_, [this, problem = std::string(error.what())] { fatal_ = problem; });
      }
    });
  }
  HandleOutput();
  return reply;
}

void Daemon::HandleOutput() {
  ControllerOutput output = controller_.TakeOutput();
  Send(output.frames);
  if (output.drops_commands) {
    for (std::vector<MavFrame>& batch : waiting_) batch.clear();
  }
  for (const Json& record : output.records) {
    server_->Publish(record);
    if (record["type"] == "state") {
      job_.Info(record["to"].get<std::string>() + ": " + record["reason"].get<std::string>());
    }
  }
  for (const std::string& text : output.texts) {
    server_->Publish({{"type", "text"}, {"text", text}});
    job_.Info("vehicle: " + text);
  }
  for (FetchRequest& fetch : output.fetches) fetches_->Add(std::move(fetch));
  if (!output.records.empty() || !output.commands.empty()) {
    WriteThenSend(std::move(output.records), std::move(output.commands));
  }
}

// Disk in a worker, so that a slow one does not stop the heartbeat. Changes of state announce
// nothing that has to wait for the disk: they go with the next record that does.
void Daemon::WriteThenSend(std::vector<Json> records, std::vector<MavFrame> commands) {
  const bool can_wait = commands.empty() && !records.empty() &&
                        std::all_of(records.begin(), records.end(),
                                    [](const Json& record) { return record["type"] == "state"; });
  if (delayed_.empty()) delayed_since_s_ = WallS();
  delayed_.insert(delayed_.end(), std::make_move_iterator(records.begin()),
                  std::make_move_iterator(records.end()));
  if (can_wait) return;
  records = std::exchange(delayed_, {});
  waiting_.push_back(std::move(commands));
  asio::post(disk_, [this, records = std::move(records)] {
    std::string problem;
    try {
      if (!records.empty()) journal_.Append(records);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    asio::post(io_, [this, problem] { OnWritten(problem); });
  });
}

void Daemon::OnWritten(const std::string& problem) {
  const std::vector<MavFrame> commands = std::move(waiting_.front());
  waiting_.pop_front();
  if (!problem.empty()) {
    fatal_ = problem;  // without a journal nothing is commanded
    return;
  }
  if (fatal_.empty()) Send(commands);
}

void Daemon::Send(const std::vector<MavFrame>& frames) {
  for (MavFrame frame : frames) {
    if (signing_) signing_->Sign(&frame, UnixS());
    link_->Send(MavFrameBytes(frame));
  }
}

Json Daemon::Status() {
  Json status = controller_.Status(clock_.Now(WallS()));
  const MavPeerStatistics total = statistics_.Total();
  status["link"] = {{"connection", options_.connection},
                    {"received", total.received},
                    {"lost", total.lost},
                    {"loss_ratio", total.LossRatio()},
                    {"duplicates", total.duplicates},
                    {"bad_checksums", parser_.Counts().bad_checksums},
                    {"signed", signing_.has_value()}};
  status["shadow"] = options_.driver.is_shadow;
  status["fetching"] = fetches_->size();
  return status;
}

void Daemon::Run() {
  HandleOutput();
  fetches_->SetMission(controller_.machine().mission());
  ScheduleTick();
  io_.run();
  if (!fatal_.empty()) throw Error(fatal_);
}

}  // namespace

std::string DaemonOptions::Check() const {
  if (workspace_path.empty()) return "--workspace_path is required";
  if (api_port < 0 || api_port > 65535) return "--api_port must be from 0 to 65535";
  if (!(simulated_speed >= 0 && simulated_speed <= 1000)) {
    return "--simulated_speed must be from 0 to 1000";
  }
  const std::string complaint = flight.Check();
  return complaint.empty() ? driver.Check() : complaint;
}

void BindOptions(OptionSet& set, DaemonOptions* options) {
  set.Add("", "workspace_path", &options->workspace_path, "folder of the session");
  set.Add("", "connection", &options->connection,
          "udpin://0.0.0.0:14550, udpout://host:port, tcp://host:port or "
          "serial:///dev/ttyACM0:57600");
  set.Add("", "signing_key_file", &options->signing_key_file,
          "32 bytes, or 64 hexadecimal digits: sign, and refuse what is not signed");
  set.Add("", "api_port", &options->api_port,
          "port of the API on 127.0.0.1; 0: any free one (flightd.json says which)");
  set.Add("", "picture_url", &options->picture_url,
          "where the camera's pictures are, with {index} or {index5} and {resolution}: http://… or "
          "mftp://[;comp=100]/…; default: as the camera says");
  set.Add("", "capture_folder", &options->capture_folder,
          "folder in which somebody else puts the pictures");
  set.Add("", "simulated_speed", &options->simulated_speed,
          "speed of a simulated vehicle's clock, which is then ours, too; 0: a real vehicle");
  set.Add("", "shadow", &options->driver.is_shadow, "send nothing: watch, beside a human pilot");
  BindOptions(set, &options->flight);
  BindOptions(set, &options->driver);
}

void RunFlightDaemon(const DaemonOptions& options, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  RequireWritableFolder(options.workspace_path, "workspace");
  const FileLock lock(
      DaemonLockPath(options.workspace_path),
      options.workspace_path.string() + ": another flight daemon flies for this workspace");
  Daemon daemon(options, job);
  daemon.Run();
}

}  // namespace colmap_ext
