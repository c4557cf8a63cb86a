// Ctrl-C as a flag, for every program.
#pragma once

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Turns SIGINT and SIGTERM into a flag that stages look at; a second one ends the process at once.
// The signals are blocked in every thread and awaited in one, so no state is shared with a handler.
class SignalWatcher {
 public:
  // `log` is told of the first one.
  SignalWatcher(std::atomic<bool>* cancel, ProgressSink* log) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    thread_ = std::jthread([signals, cancel, log](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const timespec interval{0, 100'000'000};
        if (sigtimedwait(&signals, nullptr, &interval) < 0) continue;
        if (cancel->exchange(true)) _exit(1);
        log->Message(LogLevel::kWarning,
                     "stopping after the work at hand; once more to stop at once");
      }
    });
  }

 private:
  std::jthread thread_;
};

}  // namespace colmap_ext
