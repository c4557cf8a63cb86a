// What the page's server answers, apart from sockets.
#pragma once

#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// What the session says about itself while it runs. Thread-safe.
class LiveState {
 public:
  void Message(LogLevel level, std::string_view text);
  void Progress(std::string_view stage, std::size_t done, std::size_t total);
  void Finish();
  // {"running", "stage", "done", "total", "next", "messages": [{"level", "text"}]}, the messages
  // from number `since` on; "next": the number after the last.
  std::string ToJson(std::size_t since, const std::string& token, const std::string& version) const;

 private:
  struct Entry {
    LogLevel level;
    std::string text;
  };
  mutable std::mutex mutex_;
  bool is_running_ = true;
  std::string stage_;
  std::size_t done_ = 0, total_ = 0;
  std::size_t first_ = 0;  // number of messages_.front()
  std::deque<Entry> messages_;
};

struct PageRequest {
  std::string method, target, host, origin, token, body;
};

// A request to the flight daemon that answers the page's.
struct DaemonCall {
  std::string method, target, body;
};

struct PageAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::optional<DaemonCall> call;  // instead of the above: ask the daemon
  // Instead of the above: server-sent events, messages from this number on.
  std::optional<std::size_t> events_since = std::nullopt;
};

struct PageContext {
  std::filesystem::path report;  // folder of the page
  std::filesystem::path assets;  // for a session without a page yet; may be empty
  std::string title;
  int port = 0;
  std::string token;  // what a POST must bring
  const LiveState* live = nullptr;
};

// What /api/events sends: an event with LiveState::ToJson whenever that says something new.
class LiveEvents {
 public:
  LiveEvents(const PageContext* context, std::size_t since) : context_(context), next_(since) {}
  // "data: {…}\n\n"; empty when there is nothing new.
  std::string Next();

 private:
  const PageContext* context_;  // must outlive this
  std::size_t next_;
  std::string last_;
};

// GET of the page's files, /api/live, /api/events and /api/flight; POST of
// /api/flight/{pause,resume,abort} with the token that /api/live tells (a foreign web page cannot
// read it). Anything else, a Host other than this server's, a foreign Origin and paths that leave
// the folder are refused.
PageAnswer AnswerPageRequest(const PageRequest& request, const PageContext& context);

}  // namespace colmap_ext
