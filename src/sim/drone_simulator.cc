#include "colmap_ext/sim/drone_simulator.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/error.h"
#include "sim/drone_simulator_impl.h"

namespace colmap_ext {
namespace {

constexpr std::chrono::milliseconds kTurn(4);  // wall time between turns of the loop
constexpr double kSlice_s = 0.02;              // simulated time between looks at the links
constexpr double kMostPerTurn_s = 2;           // simulated; then the links have their turn
constexpr double kWatched_m = 50;              // clearance beyond this is not told apart

double UnixTime() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

Json ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::string DroneSimulatorOptions::Check() const {
  if (http_port < 0 || http_port > 65535) return "http_port must be in [0, 65535]";
  if (!(speed >= 0.1 && speed <= 100)) return "speed must be in [0.1, 100]";
  return autopilot.Check();
}

DroneSimulator::Impl::Impl(boost::asio::io_context* the_io, const DroneSimulatorOptions& o,
                           const GeoPosition& the_origin, const Eigen::Vector3d& the_home,
                           const DroneSite& the_site, std::function<void()> the_crash,
                           const JobControl& the_job)
    : io(the_io),
      options(o),
      origin(the_origin),
      home(the_home),
      site(the_site),
      crash(std::move(the_crash)),
      job(the_job),
      drone(o.autopilot, the_origin, the_home, the_site.Ground()),
      uplink({}, 2 * o.autopilot.seed + 1),
      downlink({}, 2 * o.autopilot.seed + 2),
      timer(*the_io),
      clearance_m(kWatched_m),
      min_clearance_m(kWatched_m) {
  faults.wind = o.autopilot.motion.wind;
}

void DroneSimulator::Impl::Open(const SimulatedCamera& camera) {
  Change(options.faults);
  if (!options.signing_key_path.empty()) {
    EnableSigning(ReadMavSigningKey(options.signing_key_path));
  }
  HttpServerOptions http_options;
  http_options.port = static_cast<std::uint16_t>(options.http_port);
  const auto weak = weak_from_this();
  http.emplace(*io, http_options, [weak](const HttpRequest& request, HttpServer::Respond respond) {
    if (const auto self = weak.lock()) self->Answer(request, std::move(respond));
  });
  drone.SetPictureUrl("http://127.0.0.1:" + std::to_string(http->port()) + "/pictures");
  pictures.emplace(
      camera, options.output_path, options.renders_full,
      [weak, the_io = io](const std::string& name, PhotoResolution resolution) {
        boost::asio::post(*the_io, [weak, name, resolution] {
          if (const auto self = weak.lock()) self->PictureDone(name, resolution);
        });
      },
      job);
  ftp.emplace(options.output_path, MavFtpServerOptions());
  link.emplace(io, ParseMavLinkUrl(options.connection));
  link->Start({[weak](std::span<const std::uint8_t> bytes, bool) {
                 const auto self = weak.lock();
                 if (self && self->is_running) self->uplink.Send(bytes, self->time_s);
               },
               nullptr});
}

void DroneSimulator::Impl::Start() {
  started_at = std::chrono::steady_clock::now();
  is_running = true;
  Schedule();
}

void DroneSimulator::Impl::Stop() {
  is_running = false;
  timer.cancel();
  link.reset();
  waiting.clear();
  http.reset();
}

void DroneSimulator::Impl::Schedule() {
  timer.expires_after(kTurn);
  timer.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
    const auto self = weak.lock();
    if (error || !self || !self->is_running) return;
    self->Advance();
    self->Schedule();
  });
}

// Up to where the wall clock says; a machine that was busy catches up over several turns.
void DroneSimulator::Impl::Advance() {
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - started_at).count();
  const double until_s = std::min(wall_s * options.speed, time_s + kMostPerTurn_s);
  while (time_s + kSlice_s <= until_s) Slice();
}

void DroneSimulator::Impl::Slice() {
  uplink.Deliver(time_s, [this](std::span<const std::uint8_t> packet) { ReceivePacket(packet); });
  drone.Step(kSlice_s);
  time_s += kSlice_s;
  for (const auto& message : ftp->Poll(time_s)) drone.SendAsCamera(message);
  for (const MavFrame& frame : drone.TakeFrames()) SendFrame(frame);
  for (const ShutterEvent& event : drone.TakeShutterEvents()) pictures->Add(event);
  if (const auto bytes = drone.TakeSigningKey(); bytes.size() == MavSigningKey().size()) {
    MavSigningKey key;
    std::copy(bytes.begin(), bytes.end(), key.begin());
    EnableSigning(key);
  }
  downlink.Deliver(time_s, [this](std::span<const std::uint8_t> packet) { link->Send(packet); });
  if (time_s >= next_clearance_s) WatchClearance();
}

void DroneSimulator::Impl::WatchClearance() {
  next_clearance_s = time_s + 0.1;
  const MotionState state = drone.Truth().motion;
  clearance_m = site.Clearance(state.position, kWatched_m);
  if (!state.on_ground) min_clearance_m = std::min(min_clearance_m, clearance_m);
}

void DroneSimulator::Impl::EnableSigning(const MavSigningKey& key) {
  signing.emplace(key, MavSigningOptions(), MavSigningState(), [](const MavSigningState&) {});
}

void DroneSimulator::Impl::SendFrame(const MavFrame& frame) {
  MavFrame sent = frame;
  if (signing) signing->Sign(&sent, UnixTime());
  downlink.Send(MavFrameBytes(sent), time_s);
}

void DroneSimulator::Impl::ReceivePacket(std::span<const std::uint8_t> packet) {
  const auto receive = [this](const MavFrame& frame) { ReceiveFrame(frame); };
  parser.Feed(packet, receive);
  parser.EndOfDatagram(receive);
}

void DroneSimulator::Impl::ReceiveFrame(const MavFrame& frame) {
  if (signing && signing->Check(frame, UnixTime()) != MavSignatureVerdict::kAccepted) return;
  if (const auto message = UnpackMav<MavFileTransferProtocol>(frame)) {
    return ReceiveFtp(*message, frame);
  }
  drone.Receive(frame);
}

// Only component 100 has files; an autopilot's own storage would not have the pictures.
void DroneSimulator::Impl::ReceiveFtp(const MavFileTransferProtocol& message,
                                      const MavFrame& frame) {
  if (message.target_system != options.autopilot.system_id ||
      message.target_component != MavComponent::kCamera) {
    return;
  }
  for (const auto& answer : ftp->Receive(message, frame, time_s)) drone.SendAsCamera(answer);
}

void DroneSimulator::Impl::Change(const std::string& faults_json) {
  DroneFaults changed = faults;
  const DroneEvents events = ChangeFaults(faults_json, &changed);
  if (events.pilot_mode) drone.PilotSwitch(*events.pilot_mode);  // may refuse: first
  faults = changed;
  Apply(faults, &drone);
  uplink.SetOptions(faults.link);
  downlink.SetOptions(faults.link);
  if (events.battery_percent) drone.SetBatteryPercent(*events.battery_percent);
  if (events.crash) crash();
}

Json DroneSimulator::Impl::Status() const {
  const DroneTruth truth = drone.Truth();
  const GeoPosition place = GeoFromEnu(origin, truth.motion.position);
  return {{"time_s", truth.time_s},
          {"speed", options.speed},
          {"personality",
           options.autopilot.personality == AutopilotPersonality::kPx4 ? "px4" : "ardupilot"},
          {"mode", truth.mode},
          {"armed", truth.is_armed},
          {"landed", truth.is_landed},
          {"crashed", truth.has_crashed},
          {"failsafe", truth.failsafe},
          {"position_enu_m", ToJson(truth.motion.position)},
          {"lat", place.lat_deg},
          {"lon", place.lon_deg},
          {"amsl_m", place.height_m},
          {"velocity_enu_m_s", ToJson(truth.motion.velocity)},
          {"wind_enu_m_s", ToJson(truth.motion.wind)},
          {"yaw_deg", RadToDeg(truth.motion.yaw_rad)},
          {"gimbal",
           {{"pitch_deg", RadToDeg(truth.gimbal_pitch_rad)},
            {"heading_deg", RadToDeg(truth.gimbal_heading_rad)}}},
          {"battery_percent", truth.battery_percent},
          {"clearance_m", clearance_m},
          {"min_clearance_m", min_clearance_m},
          {"captures", truth.captures},
          {"rendered", truth.captures - pictures->NumWaiting()},
          {"pilot_takeovers", truth.pilot_takeovers},
          {"commands",
           {{"motion", truth.motion_commands},
            {"arm", truth.arm_commands},
            {"capture", truth.capture_commands},
            {"last_motion_s", truth.last_motion_command_s}}},
          {"link",
           {{"sent", downlink.Counts().sent},
            {"received", uplink.Counts().sent},
            {"lost", downlink.Counts().lost + uplink.Counts().lost},
            {"is_signed", signing.has_value()}}},
          {"faults", colmap_ext::ToJson(faults)}};
}

DroneSimulator::DroneSimulator(boost::asio::io_context* io, const DroneSimulatorOptions& options,
                               const GeoPosition& origin, const Eigen::Vector3d& home,
                               const DroneSite& site, const SimulatedCamera& camera,
                               std::function<void()> crash, const JobControl& job) {
  ThrowIfInvalid(options.Check());
  impl_ = std::make_shared<Impl>(io, options, origin, home, site, std::move(crash), job);
  impl_->Open(camera);
}

DroneSimulator::~DroneSimulator() {
  Stop();
  impl_->pictures.reset();
}

void DroneSimulator::Start() { impl_->Start(); }
void DroneSimulator::Stop() { impl_->Stop(); }
Json DroneSimulator::Status() const { return impl_->Status(); }
int DroneSimulator::http_port() const { return impl_->http->port(); }

Json DroneSimulator::ReadyLine() const {
  const GeoPosition place = GeoFromEnu(impl_->origin, impl_->home);
  MavLinkUrl url = ParseMavLinkUrl(impl_->options.connection);
  const bool listens = url.kind == MavLinkKind::kUdpIn || url.kind == MavLinkKind::kTcpIn;
  if (listens) url.port = impl_->link->LocalPort();
  return {{"http_port", http_port()},
          {"connection", MavLinkUrlText(url)},
          {"personality", impl_->Status()["personality"]},
          {"speed", impl_->options.speed},
          {"home",
           {{"lat", place.lat_deg},
            {"lon", place.lon_deg},
            {"amsl_m", place.height_m},
            {"enu_m", ToJson(impl_->home)}}},
          {"origin",
           {{"lat", impl_->origin.lat_deg},
            {"lon", impl_->origin.lon_deg},
            {"height_m", impl_->origin.height_m}}}};
}

}  // namespace colmap_ext
