#include "colmap_ext/mavlink/link.h"

#include <utility>

#include "mavlink/transport.h"

namespace colmap_ext {

MavLink::MavLink(boost::asio::io_context* io, const MavLinkUrl& url) {
  switch (url.kind) {
    case MavLinkKind::kUdpIn:
    case MavLinkKind::kUdpOut:
      transport_ = MakeUdpTransport(io, url);
      break;
    case MavLinkKind::kTcp:
    case MavLinkKind::kTcpIn:
      transport_ = MakeTcpTransport(io, url);
      break;
    case MavLinkKind::kSerial:
      transport_ = MakeSerialTransport(io, url);
      break;
  }
}

MavLink::~MavLink() { Close(); }

void MavLink::Start(MavLinkEvents events) { transport_->Start(std::move(events)); }
void MavLink::Send(std::span<const std::uint8_t> bytes) { transport_->Send(bytes); }
void MavLink::Close() { transport_->Close(); }
bool MavLink::IsOpen() const { return transport_->IsOpen(); }
std::uint16_t MavLink::LocalPort() const { return transport_->LocalPort(); }
const MavLinkCounts& MavLink::Counts() const { return transport_->Counts(); }

}  // namespace colmap_ext
