// What TCP and serial links share: reading, a bounded queue for writing, opening again.
#pragma once

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mavlink/transport.h"

namespace colmap_ext {

template <typename Stream>
class StreamTransport : public MavTransport {
 public:
  StreamTransport(boost::asio::io_context* io, const MavLinkUrl& url)
      : MavTransport(io, url), retry_timer_(*io) {}

  void Send(std::span<const std::uint8_t> bytes) override {
    if (!IsOpen() || queued_bytes_ + bytes.size() > kMaxQueuedBytes) {
      ++counts_.sends_dropped;
      return;
    }
    queue_.emplace_back(bytes.begin(), bytes.end());
    queued_bytes_ += bytes.size();
    if (queue_.size() == 1) WriteFirst();
  }

 protected:
  // Takes a stream that is connected and starts to read.
  void Use(Stream stream) {
    ++generation_;
    stream_.emplace(std::move(stream));
    queue_.clear();
    queued_bytes_ = 0;
    pause_ = kShortestPause;
    SetOpen(true, "");
    if (stream_) ReadNext();
  }

  // The stream failed or could not be opened. Calls Open again later, if `retry`.
  void Lose(const boost::system::error_code& error, bool retry) {
    DropStream();
    if (is_closed_) return;
    SetOpen(false, error.message());
    if (!retry || is_closed_) return;
    retry_timer_.expires_after(pause_);
    pause_ = std::min(2 * pause_, kLongestPause);
    retry_timer_.async_wait([this, self = shared_from_this()](const auto& wait_error) {
      if (!wait_error && !is_closed_) Open();
    });
  }

  void CloseSocket() override {
    retry_timer_.cancel();
    DropStream();
  }

  // What to do when an established stream is lost.
  virtual void Lost(const boost::system::error_code& error) = 0;

 private:
  static constexpr std::size_t kMaxQueuedBytes = 256 * 1024;
  static constexpr std::chrono::milliseconds kShortestPause{500};
  static constexpr std::chrono::milliseconds kLongestPause{5000};

  void DropStream() {
    ++generation_;
    if (!stream_) return;
    boost::system::error_code ignored;
    stream_->close(ignored);
    stream_.reset();
  }

  void ReadNext() {
    stream_->async_read_some(boost::asio::buffer(buffer_),
                             [this, self = shared_from_this(), was = generation_](
                                 const boost::system::error_code& error, std::size_t count) {
                               if (is_closed_ || was != generation_) return;
                               if (error) {
                                 Lost(error);
                                 return;
                               }
                               counts_.bytes_received += count;
                               events_.receive(std::span(buffer_.data(), count), false);
                               if (!is_closed_ && was == generation_) ReadNext();
                             });
  }

  void WriteFirst() {
    // The bytes live in the handler: the queue may be emptied while they are written.
    auto bytes = std::make_shared<std::vector<std::uint8_t>>(std::move(queue_.front()));
    boost::asio::async_write(*stream_, boost::asio::buffer(*bytes),
                             [this, self = shared_from_this(), bytes, was = generation_](
                                 const boost::system::error_code& error, std::size_t count) {
                               if (is_closed_ || was != generation_) return;
                               counts_.bytes_sent += count;
                               if (error) {
                                 Lost(error);
                                 return;
                               }
                               queued_bytes_ -= bytes->size();
                               queue_.pop_front();
                               if (!queue_.empty()) WriteFirst();
                             });
  }

  std::optional<Stream> stream_;
  std::uint64_t generation_ = 0;  // of stream_: what belongs to an older one is void
  std::deque<std::vector<std::uint8_t>> queue_;
  std::size_t queued_bytes_ = 0;
  std::array<std::uint8_t, 16384> buffer_;
  boost::asio::steady_timer retry_timer_;
  std::chrono::milliseconds pause_ = kShortestPause;
};

}  // namespace colmap_ext
