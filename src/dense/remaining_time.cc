#include "dense/remaining_time.h"

#include <cmath>
#include <utility>

namespace colmap_ext {

std::string DurationText(double seconds) {
  const long s = std::lround(seconds);
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s % 3600 / 60) + " min";
}

RemainingTime::RemainingTime(std::string stage, std::size_t done, std::size_t total,
                             const JobControl& job)
    : stage_(std::move(stage)), first_(done), done_(done), total_(total), job_(job) {
  job_.Progress(stage_, done_, total_);
}

void RemainingTime::Step() {
  constexpr double kMessageInterval_s = 15;
  const std::lock_guard lock(mutex_);
  ++done_;
  job_.Progress(stage_, done_, total_);
  const auto now = Clock::now();
  if (std::chrono::duration<double>(now - last_message_).count() < kMessageInterval_s) return;
  last_message_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left =
      elapsed / static_cast<double>(done_ - first_) * static_cast<double>(total_ - done_);
  if (done_ < total_) job_.Info(stage_ + ": about " + DurationText(left) + " left");
}

}  // namespace colmap_ext
