#include <utility>

#include "colmap_ext/flight/picture_source.h"

namespace colmap_ext {

FtpPictureQueue::FtpPictureQueue(const MavFtpClientOptions& options, std::uint16_t first_sequence,
                                 int attempts)
    : client_(options, first_sequence), attempts_(attempts) {}

void FtpPictureQueue::Add(Request request) {
  auto& queue = request.full_resolution ? full_ : low_;
  queue.push_back({std::move(request), 0});
}

void FtpPictureQueue::Receive(const MavFileTransferProtocol& message, const MavFrame& from,
                              double now_s) {
  if (from.system_id != last_.system_id || from.component_id != last_.component_id) return;
  const std::optional<MavFtpPayload> payload = DecodeMavFtp(message);
  if (payload) client_.Receive(*payload, now_s);
}

void FtpPictureQueue::FinishActive() {
  Job job = std::move(*active_);
  active_.reset();
  if (client_.Status() == MavFtpStatus::kDone) {
    results_.push_back({job.request.id, client_.Data(), ""});
  } else if (job.attempts >= attempts_) {
    results_.push_back({job.request.id, {}, client_.Failure()});
  } else {
    (job.request.full_resolution ? full_ : low_).push_back(std::move(job));
  }
}

void FtpPictureQueue::BeginNext(double now_s) {
  auto& queue = low_.empty() ? full_ : low_;
  if (queue.empty()) return;
  Job job = std::move(queue.front());
  queue.pop_front();
  if (job.request.path.empty() || job.request.path.size() > kMavFtpMaxData) {
    results_.push_back({job.request.id, {}, "FTP: a path has 1 … 239 bytes"});
    return;
  }
  ++job.attempts;
  last_ = job.request;
  client_.Download(job.request.path, now_s);
  active_ = std::move(job);
}

std::vector<MavFileTransferProtocol> FtpPictureQueue::Poll(double now_s) {
  client_.Poll(now_s);
  if (active_ && client_.Status() != MavFtpStatus::kRunning) FinishActive();
  // The last file is closed on the server before another is opened there: some have one session.
  while (!active_ && !client_.NextTimeS() && !(low_.empty() && full_.empty())) BeginNext(now_s);
  std::vector<MavFileTransferProtocol> messages;
  for (const MavFtpPayload& payload : client_.TakeOutgoing()) {
    messages.push_back(EncodeMavFtp(payload, last_.system_id, last_.component_id));
  }
  return messages;
}

std::vector<FtpPictureQueue::Result> FtpPictureQueue::TakeResults() {
  return std::exchange(results_, {});
}

void FtpPictureQueue::AbortAll(const std::string& reason, double now_s) {
  if (active_) {
    client_.Abort(reason, now_s);
    results_.push_back({active_->request.id, {}, reason});
    active_.reset();
  }
  for (auto* queue : {&low_, &full_}) {
    for (const Job& job : *queue) results_.push_back({job.request.id, {}, reason});
    queue->clear();
  }
}

}  // namespace colmap_ext
