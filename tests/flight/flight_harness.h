// Plays the daemon's controller against the simulated autopilot, both ends in one process, with one
// injected clock, packets lost on request, and a journal that can be cut anywhere.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_controller.h"
#include "colmap_ext/flight/flight_journal.h"
#include "colmap_ext/sim/autopilot.h"
#include "path/box_world.h"

namespace colmap_ext::test {

// For INSTANTIATE_TEST_SUITE_P.
inline auto BothStacks() {
  return ::testing::Values(AutopilotPersonality::kPx4, AutopilotPersonality::kArduPilot);
}
inline std::string NameOfStack(const ::testing::TestParamInfo<AutopilotPersonality>& info) {
  return info.param == AutopilotPersonality::kPx4 ? "Px4" : "ArduPilot";
}

inline const GeoPosition kSite = {47.3769, 8.5417, 408};

// A building of 6 x 6 x 8 m; views around it at 12 m from its middle.
inline const Eigen::AlignedBox3d kBuilding = {Eigen::Vector3d(-3, -3, 0), Eigen::Vector3d(3, 3, 8)};

inline std::vector<FlightStop> StopsAround(int count, int first_view = 0) {
  std::vector<FlightStop> stops;
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283185307 * i / count;
    FlightStop stop;
    stop.position = {12 * std::sin(angle), -12 * std::cos(angle), 9.0 + 0.3 * (i % 3)};
    stop.direction.yaw_rad = NormalizeAngle(-angle);
    stop.direction.pitch_rad = DegToRad(-20);
    stop.view_id = first_view + i;
    stop.photo = "view_" + std::to_string(stop.view_id) + ".jpg";
    stops.push_back(stop);
  }
  return stops;
}

inline FlightMission MissionAround(int count) {
  FlightMission mission;
  mission.origin = kSite;
  mission.stops = StopsAround(count);
  mission.surface_path = "building.ply";
  mission.safe_distance_m = 4;
  mission.transit_z_m = 20;
  mission.limits.fence = {{-40, -40}, {40, -40}, {40, 40}, {-40, 40}};
  mission.at_end = AtEnd::kReturn;
  return mission;
}

inline FlightRequest LoadRequest(const FlightMission& mission) {
  FlightRequest request;
  request.kind = FlightRequest::Kind::kLoad;
  request.mission = mission;
  request.surface = std::make_shared<RayScene>(MeshOf({kBuilding}));
  request.surface_top_z_m = 8;
  return request;
}

inline FlightRequest Plain(FlightRequest::Kind kind, bool land = false) {
  FlightRequest request;
  request.kind = kind;
  request.land = land;
  return request;
}

class FlightHarness {
 public:
  struct Options {
    AutopilotPersonality personality = AutopilotPersonality::kPx4;
    std::string failsafes = "safe";
    std::string gimbal_protocol = "v2", camera_protocol = "v2";
    double loss = 0;
    std::uint32_t seed = 1;
    FlightOptions flight;
    double fetch_s = 0.8;  // from the request to the file
  };

  explicit FlightHarness(const Options& options) : options_(options), random_(options.seed) {
    AutopilotOptions drone;
    drone.personality = options.personality;
    drone.failsafes = options.failsafes;
    drone.gimbal_protocol = options.gimbal_protocol;
    drone.camera_protocol = options.camera_protocol;
    drone.seed = options.seed;
    autopilot_ = std::make_unique<SimulatedAutopilot>(drone, kSite, Eigen::Vector3d(0, -20, 0));
    StartDaemon();
  }

  void StartDaemon() {
    controller_ = std::make_unique<FlightController>(options_.flight, DriverOptions(),
                                                     ReplayJournal(journal_, "journal"));
    if (mission_) controller_->Request(*mission_, now_s_);
    fetches_.clear();
  }

  // kill -9: what was not on disk is lost, and so is what was not sent. `written`: how much of the
  // records that were on their way to the disk got there, and whether the packets behind them went.
  void KillDaemon(double written, bool sent) {
    ControllerOutput output = controller_->TakeOutput();
    std::string lines;
    for (const Json& record : output.records) lines += record.dump() + "\n";
    const bool is_whole = written >= 1;
    journal_ +=
        lines.substr(0, static_cast<std::size_t>(written * static_cast<double>(lines.size())));
    if (is_whole && sent) Deliver(output.commands);
    std::size_t whole = 0;
    ReplayJournal(journal_, "journal", &whole);
    journal_.resize(whole);  // as FlightJournal does
    controller_.reset();
  }

  FlightReply Request(const FlightRequest& request) {
    if (request.kind == FlightRequest::Kind::kLoad) mission_ = request;
    const FlightReply reply = controller_->Request(request, now_s_);
    HandleOutput();
    return reply;
  }
  void Accept(const FlightRequest& request) {
    const FlightReply reply = Request(request);
    EXPECT_TRUE(reply.is_accepted) << reply.reason;
  }

  // Until `done`, at most `seconds`; whether it was.
  bool RunUntil(double seconds, const std::function<bool()>& done) {
    for (const double end_s = now_s_ + seconds; now_s_ < end_s;) {
      if (done()) return true;
      Step();
    }
    return done();
  }
  void Run(double seconds) {
    RunUntil(seconds, [] { return false; });
  }
  // Stops in the middle of a step where the state lasts less.
  bool RunUntilState(double seconds, FlightState state) {
    watched_ = state;
    const bool is_there = RunUntil(seconds, [&] { return this->state() == state; });
    watched_.reset();
    return is_there;
  }

  // Loads, waits for the vehicle, starts.
  void Begin(const FlightMission& mission) {
    Accept(LoadRequest(mission));
    ASSERT_TRUE(RunUntilState(40, FlightState::kIdentified)) << Describe();
    Run(25);  // the estimator
    Accept(Plain(FlightRequest::Kind::kStart));
  }

  FlightState state() const { return controller_->machine().state(); }
  const FlightLedger& ledger() const { return controller_->machine().ledger(); }
  SimulatedAutopilot& drone() { return *autopilot_; }
  DroneTruth truth() const { return autopilot_->Truth(); }
  FlightController& controller() { return *controller_; }
  const std::string& journal() const { return journal_; }
  double now_s() const { return now_s_; }
  void SetLoss(double loss) { options_.loss = loss; }
  // Nothing comes or goes.
  void CutLink(bool is_cut) { is_cut_ = is_cut; }
  bool has_daemon() const { return controller_ != nullptr; }

  std::string Describe() const {
    const DroneTruth drone = truth();
    return std::string(Name(state())) + " (" + controller_->machine().reason() + "), drone " +
           drone.mode + (drone.is_armed ? " armed" : " disarmed") + " at z " +
           std::to_string(drone.motion.position.z()) + ", t " + std::to_string(now_s_);
  }

  // Every picture that the camera took is in the ledger once, and nothing else is.
  void ExpectPicturesAccounted() const {
    std::multiset<int> indices;
    for (const auto& [view_id, entry] : ledger().views) {
      const bool has_picture =
          entry.status == ViewStatus::kCaptured || entry.status == ViewStatus::kStored;
      if (has_picture) indices.insert(entry.capture.record.index);
    }
    for (const auto& [index, report] : ledger().others) indices.insert(index);
    std::multiset<int> taken;
    for (int i = 0; i < truth().captures; ++i) taken.insert(i);
    EXPECT_EQ(indices, taken) << Describe();
  }

  int CountViews(ViewStatus status) const {
    int count = 0;
    for (const auto& [view_id, entry] : ledger().views) count += entry.status == status ? 1 : 0;
    return count;
  }

  void Step() {
    constexpr double kStep = 0.02;
    if (arrived_.empty()) {
      now_s_ += kStep;
      autopilot_->Step(kStep);
      for (const MavFrame& frame : autopilot_->TakeFrames()) arrived_.push_back(frame);
    }
    while (!arrived_.empty()) {
      const MavFrame frame = arrived_.front();
      arrived_.pop_front();
      if (controller_ == nullptr || IsLost()) continue;
      controller_->Receive(frame, now_s_);
      HandleOutput();
      if (watched_ == state()) return;
    }
    if (controller_ == nullptr) return;
    if (now_s_ >= tick_due_s_) {
      tick_due_s_ = now_s_ + 0.1;
      controller_->Tick(now_s_);
    }
    HandleOutput();
    for (auto fetch = fetches_.begin(); fetch != fetches_.end();) {
      if (now_s_ < fetch->first) {
        ++fetch;
        continue;
      }
      const FetchRequest request = fetch->second;
      fetch = fetches_.erase(fetch);
      controller_->OnStored(request.view_id, request.full_resolution, request.photo, "sha", now_s_);
      HandleOutput();
    }
  }

 private:
  bool IsLost() {
    return is_cut_ || (options_.loss > 0 &&
                       std::uniform_real_distribution<double>(0, 1)(random_) < options_.loss);
  }

  void Deliver(const std::vector<MavFrame>& frames) {
    for (const MavFrame& frame : frames) {
      if (!IsLost()) autopilot_->Receive(frame);
    }
  }

  void HandleOutput() {
    const ControllerOutput output = controller_->TakeOutput();
    for (const Json& record : output.records) journal_ += record.dump() + "\n";
    Deliver(output.frames);
    Deliver(output.commands);
    for (const FetchRequest& fetch : output.fetches) {
      fetches_.emplace_back(now_s_ + options_.fetch_s, fetch);
    }
  }

  Options options_;
  std::mt19937 random_;
  std::unique_ptr<SimulatedAutopilot> autopilot_;
  std::unique_ptr<FlightController> controller_;
  std::optional<FlightRequest> mission_;
  std::string journal_;
  std::vector<std::pair<double, FetchRequest>> fetches_;
  std::deque<MavFrame> arrived_;  // not yet received
  std::optional<FlightState> watched_;
  double now_s_ = 0, tick_due_s_ = 0;
  bool is_cut_ = false;
};

}  // namespace colmap_ext::test
