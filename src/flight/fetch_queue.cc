#include "flight/fetch_queue.h"

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/mavlink/ftp_payload.h"
#include "flight/picture_fetch.h"
#include "flight/picture_store.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;

constexpr int kAttempts = 6;
constexpr int kAtOnce = 2;
constexpr auto kPause = std::chrono::seconds(2);  // before another attempt

struct Job {
  FetchRequest request;
  int attempts = 0;
};

}  // namespace

struct FetchQueue::Impl : std::enable_shared_from_this<FetchQueue::Impl> {
  Impl(asio::io_context* given_io, asio::thread_pool* given_workers, const DaemonOptions& given,
       Events given_events)
      : io(given_io), workers(given_workers), options(given), events(std::move(given_events)) {}

  void Pump();
  void Begin(Job job);
  // In a worker: gets the bytes by `get`, and stores them.
  void Store(Job job, std::function<std::string()> get);
  void Finish(Job job, const std::string& sha256, const std::string& problem);
  void TakeFtpResults();

  asio::io_context* io;
  asio::thread_pool* workers;
  DaemonOptions options;
  Events events;
  FlightMission mission;
  std::deque<Job> low, full;
  int active = 0, paused = 0;
  bool is_stopped = false;

  // One try a transfer: this queue repeats.
  FtpPictureQueue ftp{MavFtpClientOptions(), static_cast<std::uint16_t>(std::random_device()()), 1};
  std::map<std::uint64_t, std::pair<Job, MavFtpUrl>> ftp_jobs;  // by number; waiting or under way
  std::set<std::uint64_t> ftp_begun;
  std::uint64_t next_ftp_job = 0;
};

void FetchQueue::Impl::Pump() {
  while (!is_stopped && active < kAtOnce && !(low.empty() && full.empty())) {
    std::deque<Job>& queue = low.empty() ? full : low;
    Job job = std::move(queue.front());
    queue.pop_front();
    ++active;
    ++job.attempts;
    Begin(std::move(job));
  }
}

void FetchQueue::Impl::Begin(Job job) {
  if (options.capture_folder.empty()) {
    if (const auto url = ParseMavFtpUrl(PictureUrl(job.request, options.picture_url))) {
      ftp_jobs.emplace(next_ftp_job++, std::pair(std::move(job), *url));
      return;
    }
  }
  const FetchRequest request = job.request;
  Store(std::move(job), [self = shared_from_this(), request] {
    return FetchPicture(request, {self->options.picture_url, self->options.capture_folder});
  });
}

void FetchQueue::Impl::Store(Job job, std::function<std::string()> get) {
  asio::post(*workers, [self = shared_from_this(), job = std::move(job), get = std::move(get),
                        mission = mission] {
    std::string sha256, problem;
    try {
      sha256 = StorePicture(Workspace(self->options.workspace_path), job.request, mission, get());
    } catch (const std::exception& error) {
      problem = error.what();
    }
    asio::post(*self->io, [self, job, sha256, problem] { self->Finish(job, sha256, problem); });
  });
}

void FetchQueue::Impl::TakeFtpResults() {
  for (FtpPictureQueue::Result& result : ftp.TakeResults()) {
    const auto found = ftp_jobs.find(result.id);
    if (found == ftp_jobs.end()) continue;
    Job job = std::move(found->second.first);
    ftp_jobs.erase(found);
    ftp_begun.erase(result.id);
    if (!result.failure.empty()) {
      const std::string problem = job.request.photo + ": " + result.failure;
      Finish(std::move(job), "", problem);
      continue;
    }
    Store(std::move(job),
          [bytes = std::move(result.bytes)] { return std::string(bytes.begin(), bytes.end()); });
  }
}

void FetchQueue::Impl::Finish(Job job, const std::string& sha256, const std::string& problem) {
  --active;
  if (is_stopped) return;
  if (problem.empty()) {
    events.stored(job.request, sha256);
  } else if (job.attempts >= kAttempts) {
    events.failed(job.request, problem);
  } else {
    ++paused;
    auto timer = std::make_shared<asio::steady_timer>(*io, kPause);
    timer->async_wait([self = shared_from_this(), timer, job = std::move(job)](const auto& error) {
      --self->paused;
      if (error || self->is_stopped) return;
      (job.request.full_resolution ? self->full : self->low).push_back(job);
      self->Pump();
    });
  }
  Pump();
}

void FetchQueue::Receive(const MavFrame& frame, double now_s) {
  const auto message = UnpackMav<MavFileTransferProtocol>(frame);
  if (message) impl_->ftp.Receive(*message, frame, now_s);
}

std::vector<MavFileTransferProtocol> FetchQueue::PollFtp(int vehicle_system, bool is_heard,
                                                         double now_s) {
  if (!is_heard || impl_->ftp_jobs.empty()) {
    if (impl_->ftp.NextTimeS() && is_heard) return impl_->ftp.Poll(now_s);  // its farewell
    return {};
  }
  for (const auto& [id, job] : impl_->ftp_jobs) {
    if (!impl_->ftp_begun.insert(id).second) continue;
    const auto& [request, url] = job;
    impl_->ftp.Add({id, static_cast<std::uint8_t>(vehicle_system),
                    url.component.value_or(MavComponent::kCamera), url.path,
                    request.request.full_resolution});
  }
  std::vector<MavFileTransferProtocol> messages = impl_->ftp.Poll(now_s);
  impl_->TakeFtpResults();
  return messages;
}

FetchQueue::FetchQueue(asio::io_context* io, asio::thread_pool* workers,
                       const DaemonOptions& options, Events events)
    : impl_(std::make_shared<Impl>(io, workers, options, std::move(events))) {}

FetchQueue::~FetchQueue() { Stop(); }

void FetchQueue::SetMission(const FlightMission& mission) {
  impl_->mission = mission;
  impl_->mission.stops.clear();
}

void FetchQueue::Add(FetchRequest request) {
  (request.full_resolution ? impl_->full : impl_->low).push_back({std::move(request), 0});
  impl_->Pump();
}

void FetchQueue::Stop() { impl_->is_stopped = true; }

std::size_t FetchQueue::size() const {
  return impl_->low.size() + impl_->full.size() +
         static_cast<std::size_t>(impl_->active + impl_->paused);
}

}  // namespace colmap_ext
