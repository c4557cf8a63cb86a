// Serves the page of a session while it runs (docs/file_formats.md, "The live page").
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "colmap_ext/report/session_page.h"
#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// On 127.0.0.1 only. It is also the sink of the session's messages and progress, which it shows on
// the page and passes on. What it serves is read from disk at each request, in a thread of its own.
class PageServer : public ProgressSink {
 public:
  // `port`: 0 … 65535; 0: any free one. `next`: gets all messages and progress, too; not owned, may
  // be null. Throws UsageError for another port, Error when it cannot be had.
  PageServer(const Workspace& workspace, const PageOptions& options, int port, ProgressSink* next);
  ~PageServer() override;
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const;
  // "http://127.0.0.1:8080/"
  std::string url() const;

  void Message(LogLevel level, std::string_view text) override;
  void Progress(std::string_view stage, std::size_t done, std::size_t total) override;
  // The session's work is done; the page stays.
  void Finish();
  // Returns when the user asks to stop.
  static void WaitUntilCancelled(const JobControl& job);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
