// How good a link is: packets lost, repeated and late by their numbers; round trip by TIMESYNC and
// PING. Time comes by argument, from any clock that does not go back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "colmap_ext/mavlink/codec.h"

namespace colmap_ext {

struct MavPeerStatistics {
  std::uint64_t received = 0;    // each packet once
  std::uint64_t lost = 0;        // numbers that never came; one that comes late is taken back
  std::uint64_t duplicates = 0;  // numbers that came again
  std::uint64_t late = 0;        // came behind a packet that was sent after them
  std::uint64_t outages = 0;     // silences of more than kMavOutageS
  double last_heard_s = 0;
  // Share of what was sent that never came, 0 when nothing came. Numbers wrap at 256: what an
  // outage swallowed is not in it.
  double LossRatio() const {
    const auto sent = static_cast<double>(received + lost);
    return sent > 0 ? static_cast<double>(lost) / sent : 0;
  }
};

inline constexpr double kMavOutageS = 2.0;

enum class MavArrival { kInOrder, kLate, kDuplicate };

// Counts by sender, (system, component). A forwarder that numbers several components in one row
// shows as loss.
class MavLinkStatistics {
 public:
  MavArrival Received(const MavFrame& frame, double now_s);
  const std::map<std::pair<std::uint8_t, std::uint8_t>, MavPeerStatistics>& Peers() const {
    return statistics_;
  }
  // Sum over all senders; last_heard_s is the latest.
  MavPeerStatistics Total() const;

 private:
  struct Window {
    std::uint8_t newest = 0;
    std::uint64_t seen[2] = {0, 0};  // bit i: number newest - i has come, 128 bits
    void Shift(std::size_t count);
    bool Mark(std::size_t age);  // whether it was marked already
  };
  std::map<std::pair<std::uint8_t, std::uint8_t>, MavPeerStatistics> statistics_;
  std::map<std::pair<std::uint8_t, std::uint8_t>, Window> windows_;
};

// Round trips to one peer, over a window of the last `kWindow`.
class MavRoundTrip {
 public:
  static constexpr std::size_t kWindow = 256;

  // A request to send. At most kWindow stay open; the oldest are given up.
  MavTimesync RequestTimesync(double now_s, std::uint8_t target_system = 0,
                              std::uint8_t target_component = 0);
  MavPing RequestPing(double now_s);
  // Whether the message answers a request of ours that had no answer yet.
  bool Receive(const MavTimesync& answer, double now_s);
  bool Receive(const MavPing& answer, double now_s);

  // Seconds; nothing before the first answer.
  std::optional<double> LatestS() const;
  // `share` 0.5 is the median, 0.99 the 99th percentile.
  std::optional<double> QuantileS(double share) const;
  // Peer's clock minus ours, from the quickest TIMESYNC in the window: wrong by at most half of its
  // round trip.
  std::optional<double> ClockOffsetS() const;
  std::uint64_t Unanswered() const { return unanswered_; }  // given up

 private:
  struct Trip {
    double duration_s;
    std::optional<double> offset_s;
  };
  void Open(std::int64_t request, double now_s, std::map<std::int64_t, double>* open);
  static std::optional<double> Close(std::int64_t request, double now_s,
                                     std::map<std::int64_t, double>* open);
  void Keep(const Trip& trip);

  std::map<std::int64_t, double> open_timesyncs_;  // by ts1: when sent
  std::map<std::int64_t, double> open_pings_;      // by seq
  std::deque<Trip> trips_;
  std::uint64_t unanswered_ = 0;
  std::uint32_t ping_number_ = 0;
};

// What to answer to somebody's request; nothing when the message is an answer, or is for another
// system. `own_clock_s` is the clock that the asker shall learn of.
std::optional<MavTimesync> AnswerTimesync(const MavTimesync& request, const MavFrame& frame,
                                          std::uint8_t own_system, double own_clock_s);
std::optional<MavPing> AnswerPing(const MavPing& request, const MavFrame& frame);

}  // namespace colmap_ext
