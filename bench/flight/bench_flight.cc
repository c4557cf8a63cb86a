// The daemon as a process of its own, over UDP and HTTP on loopback, beside a simulated autopilot
// in accelerated time: a whole mission, what the daemon costs, and how long a command takes.
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "colmap_ext/flight/flight_client.h"
#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/sim/autopilot.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "support/bench_main.h"
#include "support/bench_report.h"

namespace colmap_ext {
namespace {

constexpr double kPollS = 0.2;  // between questions for the status, as active_capture asks

namespace asio = boost::asio;
namespace fs = std::filesystem;

struct BenchOptions {
  fs::path work_path;
  fs::path results_path = "bench/results";
  fs::path program = "build/bin/colmap_ext_flightd";
  int views = 108;
  int commands = 200;
  double speed = 20;
};

double WallS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

// User and system time of a process so far.
double CpuS(int pid) {
  std::ifstream stream("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(stream, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// Answers every request with the same bytes, which begin and end as a JPEG does.
class PictureServer {
 public:
  PictureServer() : acceptor_(io_, {asio::ip::address_v4::loopback(), 0}) {
    thread_ = std::jthread([this] { Serve(); });
  }
  ~PictureServer() {
    boost::system::error_code ignored;
    is_over_ = true;
    asio::ip::tcp::socket wake(io_);
    wake.connect(acceptor_.local_endpoint(), ignored);
  }
  int port() const { return acceptor_.local_endpoint().port(); }

 private:
  void Serve() {
    std::string picture = "\xFF\xD8\xFF";
    picture.resize(60000, 'x');
    picture += "\xFF\xD9";
    while (!is_over_) {
      boost::system::error_code error;
      asio::ip::tcp::socket socket(io_);
      acceptor_.accept(socket, error);
      std::string request;
      asio::read_until(socket, asio::dynamic_buffer(request), "\r\n\r\n", error);
      const std::string head =
          "HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nConnection: close\r\n"
          "Content-Length: " +
          std::to_string(picture.size()) + "\r\n\r\n";
      asio::write(socket, asio::buffer(head + picture), error);
    }
  }

  asio::io_context io_;
  asio::ip::tcp::acceptor acceptor_;
  std::atomic<bool> is_over_ = false;
  std::jthread thread_;
};

// The autopilot behind a UDP link, its clock `speed` times the wall's. Notes when commands come.
class Vehicle {
 public:
  Vehicle(int port, double speed, const GeoPosition& origin)
      : speed_(speed),
        autopilot_(Options(), origin, Eigen::Vector3d(0, -30, 0)),
        link_(&io_, ParseMavLinkUrl("udpout://127.0.0.1:" + std::to_string(port))) {
    MavLinkEvents events;
    events.receive = [this](std::span<const std::uint8_t> bytes, bool ends_datagram) {
      const auto take = [this](const MavFrame& frame) { Take(frame); };
      parser_.Feed(bytes, take);
      if (ends_datagram) parser_.EndOfDatagram(take);
    };
    link_.Start(std::move(events));
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }

  // Wall time of the first command of this number after `since_s`; 0: none came in a second.
  double WaitForCommand(MavCmd command, double since_s) {
    std::unique_lock lock(mutex_);
    const auto has_come = [&] { return last_command_[command] > since_s; };
    news_.wait_for(lock, std::chrono::seconds(1), has_come);
    return has_come() ? last_command_[command] : 0;
  }

 private:
  static AutopilotOptions Options() {
    AutopilotOptions options;
    options.failsafes = "safe";
    options.battery.battery_wh = 1000;
    return options;
  }

  void Take(const MavFrame& frame) {
    std::optional<MavCmd> command;
    if (const auto message = UnpackMav<MavCommandLong>(frame)) command = message->command;
    if (const auto message = UnpackMav<MavCommandInt>(frame)) command = message->command;
    if (command) {
      const std::lock_guard lock(mutex_);
      last_command_[*command] = WallS();
      news_.notify_all();
    }
    autopilot_.Receive(frame);
  }

  void Run(const std::stop_token& stop) {
    double before_s = WallS();
    while (!stop.stop_requested()) {
      io_.run_for(std::chrono::milliseconds(1));
      io_.restart();
      const double now_s = WallS();
      autopilot_.Step((now_s - before_s) * speed_);
      before_s = now_s;
      for (const MavFrame& frame : autopilot_.TakeFrames()) link_.Send(MavFrameBytes(frame));
    }
  }

  double speed_;
  asio::io_context io_;
  SimulatedAutopilot autopilot_;
  MavLink link_;
  MavParser parser_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::map<MavCmd, double> last_command_;
  std::jthread thread_;
};

FlightMission MissionOf(int views, const GeoPosition& origin) {
  FlightMission mission;
  mission.origin = origin;
  mission.is_vouched = true;
  mission.transit_z_m = 25;
  mission.at_end = AtEnd::kHold;
  for (int i = 0; i < views; ++i) {
    const double angle = 2 * M_PI * i / 36;
    FlightStop stop;
    stop.position = {20 * std::sin(angle), -20 * std::cos(angle), 12.0 + 3 * (i / 36)};
    stop.direction = {NormalizeAngle(-angle), -0.5};
    stop.view_id = i;
    stop.photo = "view_" + std::to_string(i) + ".jpg";
    mission.stops.push_back(stop);
  }
  return mission;
}

void WaitForState(const FlightClient& client, const std::string& state, double timeout_s) {
  const double start_s = WallS();
  while (true) {
    const Json status = client.Status();
    if (status["state"] == state) return;
    if (WallS() - start_s > timeout_s) {
      throw Error("the daemon is in " + status["state"].get<std::string>() + " (" +
                  status["reason"].get<std::string>() + "), not in " + state);
    }
    Sleep(kPollS);
  }
}

// From the request on the API to the packet at the vehicle, journal included.
void MeasureLatency(const FlightClient& client, Vehicle* vehicle, int commands,
                    BenchReport* report) {
  std::vector<double> latencies_ms;
  for (int i = 0; i < commands; ++i) {
    const double sent_s = WallS();
    if (i % 2 == 0) {
      client.Pause();
    } else {
      client.Resume();
    }
    const double came_s = vehicle->WaitForCommand(MavCmd::kDoSetMode, sent_s);
    if (came_s == 0) throw Error("a command did not come within a second");
    latencies_ms.push_back(1000 * (came_s - sent_s));
    Sleep(0.1);
  }
  std::sort(latencies_ms.begin(), latencies_ms.end());
  const auto quantile = [&](double share) {
    return latencies_ms[static_cast<std::size_t>(share * static_cast<double>(commands - 1))];
  };
  report->Add("command latency, median", quantile(0.5), "ms");
  report->Add("command latency, p99", quantile(0.99), "ms", AtMost(50));
}

int CountStored(const Json& status) {
  int count = 0;
  for (const Json& view : status["views"]) count += view["status"] == "stored" ? 1 : 0;
  return count;
}

void Measure(const BenchOptions& options, const FlightClient& client, int pid, Vehicle* vehicle,
             BenchReport* report) {
  const GeoPosition origin = {47.3769, 8.5417, 408};
  WaitForState(client, "IDENTIFIED", 60);
  Sleep(30 / options.speed);
  client.Load(MissionOf(options.views, origin));
  const double start_s = WallS(), start_cpu_s = CpuS(pid);
  client.Start();
  WaitForState(client, "HOLD", 3600);
  const double wall_s = WallS() - start_s;
  const double cpu_s = CpuS(pid) - start_cpu_s;
  report->Add("views with their picture", CountStored(client.Status()), "", AtLeast(options.views));
  report->Add("mission, wall time", wall_s, "s");
  report->Add("mission, vehicle's time", wall_s * options.speed, "s");
  report->Add("daemon, CPU", cpu_s, "CPU s");
  report->Add("daemon, CPU of wall time", 100 * cpu_s / wall_s, "%", AtMost(2));
  report->Add("daemon, CPU of vehicle's time", 100 * cpu_s / (wall_s * options.speed), "%");
  MeasureLatency(client, vehicle, options.commands, report);
  client.Abort(false);
  WaitForState(client, "DISARMED", 600);
}

int Run(const std::vector<std::string>& arguments) {
  BenchOptions options;
  OptionSet set;
  set.Add("", "work_path", &options.work_path, "folder for the workspace; required");
  set.Add("", "results_path", &options.results_path, "folder for flight.json");
  set.Add("", "program", &options.program, "the daemon");
  set.Add("", "views", &options.views, "views of the mission");
  set.Add("", "commands", &options.commands, "commands whose latency is measured");
  set.Add("", "speed", &options.speed, "vehicle's seconds a second");
  set.Parse(arguments);
  if (set.HelpRequested()) {
    std::printf("bench_flight: cost and latency of the daemon\n\n%s", set.HelpText().c_str());
    return 0;
  }
  if (options.work_path.empty()) throw UsageError("--work_path is required");
  fs::remove_all(options.work_path);
  fs::create_directories(options.work_path);
  constexpr int kPort = 24551;
  const PictureServer pictures;
  std::atomic<bool> cancel = false;
  ChildProcessOptions daemon;
  daemon.arguments = {
      options.program.string(),
      "--workspace_path",
      options.work_path.string(),
      "--connection",
      "udpin://127.0.0.1:" + std::to_string(kPort),
      "--simulated_speed",
      std::to_string(options.speed),
      "--picture_url",
      "http://127.0.0.1:" + std::to_string(pictures.port()) + "/{resolution}/{index}.jpg"};
  daemon.log_path = options.work_path / "flightd.log";
  std::jthread process([&] {
    try {
      RunChildProcess(daemon, JobControl(nullptr, &cancel));
    } catch (const std::exception&) {
      // Ended on request.
    }
  });
  std::optional<DaemonAddress> address;
  for (int i = 0; i < 200 && !address; ++i) {
    Sleep(0.05);
    address = FindDaemon(options.work_path);
  }
  if (!address) throw Error("the daemon does not start; see " + daemon.log_path.string());
  BenchReport report("flight");
  try {
    Vehicle vehicle(kPort, options.speed, {47.3769, 8.5417, 408});
    Measure(options, FlightClient(*address), address->pid, &vehicle, &report);
  } catch (...) {
    cancel = true;
    throw;
  }
  cancel = true;
  report.Write(options.results_path);
  return 0;
}

}  // namespace
}  // namespace colmap_ext

int main(int argc, char** argv) {
  return colmap_ext::BenchMain("bench_flight", argc, argv, colmap_ext::Run);
}
