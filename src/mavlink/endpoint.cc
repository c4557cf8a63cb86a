#include "colmap_ext/mavlink/endpoint.h"

namespace colmap_ext {

void MavEndpoint::Receive(std::span<const std::uint8_t> bytes, bool ends_datagram, double now_s,
                          double unix_s, const std::function<void(const MavFrame&)>& receive) {
  const auto judge = [&](const MavFrame& frame) {
    if (frame.system_id == SystemId() && frame.component_id == ComponentId()) return;
    if (signing_ && signing_->Check(frame, unix_s) != MavSignatureVerdict::kAccepted) return;
    statistics_.Received(frame, now_s);
    receive(frame);
  };
  parser_.Feed(bytes, judge);
  if (ends_datagram) parser_.EndOfDatagram(judge);
}

}  // namespace colmap_ext
