#include "flight/daemon_clock.h"

#include <algorithm>

namespace colmap_ext {

double DaemonClock::Now(double wall_s) {
  const double passed_s = std::max(0.0, wall_s - last_wall_s_);
  last_wall_s_ = std::max(last_wall_s_, wall_s);
  if (speed_ <= 0) {
    now_s_ = std::max(now_s_, wall_s);
    return now_s_;
  }
  const bool is_silent = !heard_wall_s_ || wall_s - *heard_wall_s_ > kSilenceS;
  if (is_silent) {
    now_s_ += passed_s * speed_;
    return now_s_;
  }
  const double ahead_s = std::min(kAheadS, (wall_s - *heard_wall_s_) * speed_);
  now_s_ = std::max(now_s_, heard_s_ + ahead_s);
  return now_s_;
}

void DaemonClock::OnVehicleTime(double vehicle_s, double wall_s) {
  if (speed_ <= 0) return;
  const double now_s = Now(wall_s);
  // The first word, a vehicle that was started again, or one that was silent for long.
  const bool is_new =
      !heard_wall_s_ || vehicle_s < vehicle_s_ - 1 || wall_s - *heard_wall_s_ > kSilenceS;
  if (is_new) offset_s_ = now_s - vehicle_s;
  if (!is_new && vehicle_s < vehicle_s_) return;  // overtaken on the way
  vehicle_s_ = vehicle_s;
  heard_s_ = vehicle_s + offset_s_;
  heard_wall_s_ = wall_s;
}

}  // namespace colmap_ext
