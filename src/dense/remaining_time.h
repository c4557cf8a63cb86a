// Says how far a pass over the photos is, and how long the rest will take.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// "45 s", "3 min 20 s", "2 h 5 min".
std::string DurationText(double seconds);

// Thread-safe.
class RemainingTime {
 public:
  // `done` of `total` are there from an earlier run.
  RemainingTime(std::string stage, std::size_t done, std::size_t total, const JobControl& job);
  // One more is done.
  void Step();

 private:
  using Clock = std::chrono::steady_clock;

  std::string stage_;
  std::size_t first_, done_, total_;
  const JobControl& job_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_message_ = start_;
  std::mutex mutex_;
};

}  // namespace colmap_ext
