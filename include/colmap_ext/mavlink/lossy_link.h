// One direction of a link that loses, delays, repeats and damages what it carries: by seed, the
// same every time. Time comes by argument, so that a simulation may run at any speed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace colmap_ext {

struct LossyLinkOptions {
  double loss = 0;         // share of packets that never arrive, 0 … 1
  double duplication = 0;  // share that arrives twice, 0 … 1
  double corruption = 0;   // share that arrives with one to four bits turned, 0 … 1
  double delay_s = 0;      // of every packet, s
  double jitter_s = 0;     // up to this is added at random, s: packets overtake each other
  bool is_cut = false;     // nothing arrives at all
  // Empty when the values are in their ranges.
  std::string Check() const;
};

struct LossyLinkCounts {
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t corrupted = 0;
};

class LossyLink {
 public:
  // Throws UsageError when the options are wrong.
  LossyLink(const LossyLinkOptions& options, std::uint64_t seed);
  // From now on; what is under way keeps its fate.
  void SetOptions(const LossyLinkOptions& options);
  const LossyLinkOptions& Options() const { return options_; }

  // A packet enters at `now_s`.
  void Send(std::span<const std::uint8_t> packet, double now_s);
  // Hands out what has arrived by `now_s`, in order of arrival.
  void Deliver(double now_s, const std::function<void(std::span<const std::uint8_t>)>& receive);
  // When the next packet arrives; nothing when none is under way.
  std::optional<double> NextArrivalS() const;
  const LossyLinkCounts& Counts() const { return counts_; }

 private:
  double Uniform();  // [0, 1), the same on every machine
  void Launch(std::vector<std::uint8_t> packet, double now_s);

  LossyLinkOptions options_;
  std::mt19937_64 random_;
  std::multimap<double, std::vector<std::uint8_t>> under_way_;  // by arrival
  LossyLinkCounts counts_;
};

}  // namespace colmap_ext
