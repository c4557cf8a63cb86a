#include "colmap_ext/mavlink/link_statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "colmap_ext/util/statistics.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kWindowBits = 128;

}  // namespace

bool MavLinkStatistics::Window::Mark(std::size_t age) {
  std::uint64_t& word = seen[age / 64];
  const std::uint64_t bit = std::uint64_t{1} << age % 64;
  const bool was_marked = (word & bit) != 0;
  word |= bit;
  return was_marked;
}

void MavLinkStatistics::Window::Shift(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    seen[1] = seen[1] << 1U | seen[0] >> 63U;
    seen[0] <<= 1U;
  }
  Mark(0);
}

MavArrival MavLinkStatistics::Received(const MavFrame& frame, double now_s) {
  const auto key = std::pair(frame.system_id, frame.component_id);
  MavPeerStatistics& statistics = statistics_[key];
  const auto [entry, is_new] = windows_.try_emplace(key);
  Window& window = entry->second;
  const bool was_silent = !is_new && now_s - statistics.last_heard_s > kMavOutageS;
  statistics.last_heard_s = now_s;
  if (was_silent) ++statistics.outages;
  if (is_new || was_silent) {
    // Nobody can say what came before: nothing of it counts as lost, nothing late is taken back.
    window.newest = frame.sequence;
    window.seen[0] = window.seen[1] = ~std::uint64_t{0};
    ++statistics.received;
    return MavArrival::kInOrder;
  }
  const auto ahead = static_cast<std::uint8_t>(frame.sequence - window.newest);
  if (ahead > 0 && ahead < kWindowBits) {
    window.newest = frame.sequence;
    window.Shift(ahead);
    ++statistics.received;
    statistics.lost += ahead - 1U;
    return MavArrival::kInOrder;
  }
  const auto age = static_cast<std::uint8_t>(window.newest - frame.sequence);
  if (age >= kWindowBits || window.Mark(age)) {
    ++statistics.duplicates;
    return MavArrival::kDuplicate;
  }
  ++statistics.received;
  ++statistics.late;
  --statistics.lost;
  return MavArrival::kLate;
}

MavPeerStatistics MavLinkStatistics::Total() const {
  MavPeerStatistics total;
  for (const auto& [peer, statistics] : statistics_) {
    total.received += statistics.received;
    total.lost += statistics.lost;
    total.duplicates += statistics.duplicates;
    total.late += statistics.late;
    total.outages += statistics.outages;
    total.last_heard_s = std::max(total.last_heard_s, statistics.last_heard_s);
  }
  return total;
}

MavTimesync MavRoundTrip::RequestTimesync(double now_s, std::uint8_t target_system,
                                          std::uint8_t target_component) {
  MavTimesync request;
  request.ts1 = std::max<std::int64_t>(1, std::llround(now_s * 1e9));
  while (open_timesyncs_.contains(request.ts1)) ++request.ts1;
  Open(request.ts1, now_s, &open_timesyncs_);
  request.target_system = target_system;
  request.target_component = target_component;
  return request;
}

MavPing MavRoundTrip::RequestPing(double now_s) {
  MavPing request;
  request.time_usec = static_cast<std::uint64_t>(std::max(0.0, now_s) * 1e6);
  request.seq = ping_number_++;
  Open(request.seq, now_s, &open_pings_);
  return request;
}

void MavRoundTrip::Open(std::int64_t request, double now_s, std::map<std::int64_t, double>* open) {
  open->emplace(request, now_s);
  if (open->size() <= kWindow) return;
  open->erase(open->begin());
  ++unanswered_;
}

std::optional<double> MavRoundTrip::Close(std::int64_t request, double now_s,
                                          std::map<std::int64_t, double>* open) {
  const auto found = open->find(request);
  if (found == open->end()) return std::nullopt;
  const double duration_s = now_s - found->second;
  open->erase(found);
  return duration_s;
}

void MavRoundTrip::Keep(const Trip& trip) {
  trips_.push_back(trip);
  if (trips_.size() > kWindow) trips_.pop_front();
}

bool MavRoundTrip::Receive(const MavTimesync& answer, double now_s) {
  if (answer.tc1 == 0) return false;
  const std::optional<double> duration_s = Close(answer.ts1, now_s, &open_timesyncs_);
  if (!duration_s) return false;
  const double peer_s = static_cast<double>(answer.tc1) * 1e-9;
  Keep({*duration_s, peer_s - (now_s - *duration_s / 2)});
  return true;
}

bool MavRoundTrip::Receive(const MavPing& answer, double now_s) {
  if (answer.target_system == 0) return false;
  const std::optional<double> duration_s = Close(answer.seq, now_s, &open_pings_);
  if (!duration_s) return false;
  Keep({*duration_s, std::nullopt});
  return true;
}

std::optional<double> MavRoundTrip::LatestS() const {
  if (trips_.empty()) return std::nullopt;
  return trips_.back().duration_s;
}

std::optional<double> MavRoundTrip::QuantileS(double share) const {
  if (trips_.empty()) return std::nullopt;
  std::vector<double> durations_s;
  for (const Trip& trip : trips_) durations_s.push_back(trip.duration_s);
  return Quantile(std::move(durations_s), share);
}

std::optional<double> MavRoundTrip::ClockOffsetS() const {
  const Trip* best = nullptr;
  for (const Trip& trip : trips_) {
    if (!trip.offset_s) continue;
    if (best == nullptr || trip.duration_s < best->duration_s) best = &trip;
  }
  if (best == nullptr) return std::nullopt;
  return best->offset_s;
}

std::optional<MavTimesync> AnswerTimesync(const MavTimesync& request, const MavFrame& frame,
                                          std::uint8_t own_system, double own_clock_s) {
  if (request.tc1 != 0) return std::nullopt;
  if (request.target_system != 0 && request.target_system != own_system) return std::nullopt;
  MavTimesync answer;
  answer.tc1 = std::max<std::int64_t>(1, std::llround(own_clock_s * 1e9));
  answer.ts1 = request.ts1;
  answer.target_system = frame.system_id;
  answer.target_component = frame.component_id;
  return answer;
}

std::optional<MavPing> AnswerPing(const MavPing& request, const MavFrame& frame) {
  if (request.target_system != 0 || request.target_component != 0) return std::nullopt;
  MavPing answer = request;
  answer.target_system = frame.system_id;
  answer.target_component = frame.component_id;
  return answer;
}

}  // namespace colmap_ext
