#include "colmap_ext/mavlink/lossy_link.h"

#include <cmath>
#include <utility>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

std::string LossyLinkOptions::Check() const {
  for (const auto& [name, share] : {std::pair("loss", loss), std::pair("duplication", duplication),
                                    std::pair("corruption", corruption)}) {
    if (!(share >= 0 && share <= 1)) return std::string("link: ") + name + " is not in 0 … 1";
  }
  if (!(delay_s >= 0 && delay_s <= 60)) return "link: delay_s is not in 0 … 60";
  if (!(jitter_s >= 0 && jitter_s <= 60)) return "link: jitter_s is not in 0 … 60";
  return "";
}

LossyLink::LossyLink(const LossyLinkOptions& options, std::uint64_t seed) : random_(seed) {
  SetOptions(options);
}

void LossyLink::SetOptions(const LossyLinkOptions& options) {
  ThrowIfInvalid(options.Check());
  options_ = options;
}

double LossyLink::Uniform() { return std::ldexp(static_cast<double>(random_() >> 11U), -53); }

void LossyLink::Launch(std::vector<std::uint8_t> packet, double now_s) {
  if (Uniform() < options_.corruption && !packet.empty()) {
    ++counts_.corrupted;
    for (std::size_t bits = 1 + random_() % 4; bits > 0; --bits) {
      std::uint8_t& byte = packet[random_() % packet.size()];
      byte = static_cast<std::uint8_t>(byte ^ 1U << random_() % 8);
    }
  }
  under_way_.emplace(now_s + options_.delay_s + options_.jitter_s * Uniform(), std::move(packet));
}

void LossyLink::Send(std::span<const std::uint8_t> packet, double now_s) {
  ++counts_.sent;
  if (options_.is_cut || Uniform() < options_.loss) {
    ++counts_.lost;
    return;
  }
  const bool twice = Uniform() < options_.duplication;
  Launch({packet.begin(), packet.end()}, now_s);
  if (!twice) return;
  ++counts_.duplicated;
  Launch({packet.begin(), packet.end()}, now_s);
}

void LossyLink::Deliver(double now_s,
                        const std::function<void(std::span<const std::uint8_t>)>& receive) {
  while (!under_way_.empty() && under_way_.begin()->first <= now_s) {
    // Taken out first: `receive` may send on this link.
    const auto packet = under_way_.extract(under_way_.begin());
    receive(packet.mapped());
  }
}

std::optional<double> LossyLink::NextArrivalS() const {
  if (under_way_.empty()) return std::nullopt;
  return under_way_.begin()->first;
}

}  // namespace colmap_ext
