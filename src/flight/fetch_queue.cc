#include "flight/fetch_queue.h"

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>

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
  void Finish(Job job, const std::string& sha256, const std::string& problem);

  asio::io_context* io;
  asio::thread_pool* workers;
  DaemonOptions options;
  Events events;
  FlightMission mission;
  std::deque<Job> low, full;
  int active = 0, paused = 0;
  bool is_stopped = false;
};

void FetchQueue::Impl::Pump() {
  while (!is_stopped && active < kAtOnce && !(low.empty() && full.empty())) {
    std::deque<Job>& queue = low.empty() ? full : low;
    Job job = std::move(queue.front());
    queue.pop_front();
    ++active;
    ++job.attempts;
    asio::post(*workers, [self = shared_from_this(), job = std::move(job), mission = mission] {
      std::string sha256, problem;
      try {
        const std::string bytes =
            FetchPicture(job.request, {self->options.picture_url, self->options.capture_folder});
        sha256 = StorePicture(Workspace(self->options.workspace_path), job.request, mission, bytes);
      } catch (const std::exception& error) {
        problem = error.what();
      }
      asio::post(*self->io, [self, job, sha256, problem] { self->Finish(job, sha256, problem); });
    });
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
