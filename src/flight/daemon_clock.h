// The daemon's clock: the wall's, or that of a simulated vehicle.
#pragma once

#include <optional>

namespace colmap_ext {

// With a simulated vehicle the time is what its messages say, and runs on from there at `speed` for
// a while; so a simulator that falls behind stops every timeout instead of tripping it. When
// nothing comes for kSilenceS of the wall, time runs on by itself, so that a lost link is noticed.
class DaemonClock {
 public:
  static constexpr double kSilenceS = 3;
  static constexpr double kAheadS = 0.5;  // of the vehicle's time, at most, between its messages

  // `speed` 0: the wall's clock.
  explicit DaemonClock(double speed) : speed_(speed) {}

  // `wall_s` must not go back; the result does not either.
  double Now(double wall_s);
  void OnVehicleTime(double vehicle_s, double wall_s);

 private:
  double speed_;
  double now_s_ = 0;
  std::optional<double> heard_wall_s_;
  double heard_s_ = 0;    // daemon time of the last message
  double offset_s_ = 0;   // daemon time less the vehicle's
  double vehicle_s_ = 0;  // its last word
  double last_wall_s_ = 0;
};

}  // namespace colmap_ext
