#include "colmap_ext/report/page_server.h"

#include <openssl/rand.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "colmap_ext/scene/daemon_address.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/http_client.h"
#include "colmap_ext/util/http_server.h"
#include "report/page_requests.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;

constexpr std::size_t kMaxBody = 4096;  // bytes
constexpr double kDaemonTimeoutS = 3;
constexpr std::chrono::milliseconds kNewsInterval{200};

std::string RandomToken() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    throw Error("page: the system gives no random numbers");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    constexpr char kHex[] = "0123456789abcdef";
    token += kHex[byte >> 4];
    token += kHex[byte & 15];
  }
  return token;
}

// The static page has its script inside; frames are refused, so that nobody lays a button over
// ours.
constexpr const char* kPolicy =
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
constexpr const char* kPolicyWithInlineScript =
    "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
    "script-src 'unsafe-inline'; connect-src 'none'; frame-ancestors 'none'";

HttpResponse ToResponse(const PageAnswer& answer, bool has_inline_script) {
  HttpResponse response{answer.status, answer.type, answer.body};
  response.headers = {
      {"Cache-Control", "no-cache"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Content-Security-Policy", has_inline_script ? kPolicyWithInlineScript : kPolicy}};
  return response;
}

// Blocks for as long as the daemon takes. GET without a daemon is no error: the page asks to find
// out.
PageAnswer AskDaemon(const fs::path& workspace, const DaemonCall& call) {
  try {
    if (const auto address = FindDaemon(workspace)) {
      HttpCall request{"127.0.0.1", std::to_string(address->port), call.method, call.target,
                       call.body};
      request.headers.emplace_back("Authorization", "Bearer " + address->token);
      HttpReply reply = CallHttp(request, {.total_timeout_s = kDaemonTimeoutS});
      return {reply.status, "application/json", std::move(reply.body), std::nullopt};
    }
  } catch (const Error&) {  // its file is half written, or nobody answers
  }
  if (call.method == "GET") return {200, "application/json", "null\n", std::nullopt};
  return {502, "application/json", "{\"error\": \"the flight daemon does not answer\"}\n",
          std::nullopt};
}

}  // namespace

struct PageServer::Impl {
  Impl(const Workspace& workspace, ProgressSink* sink) : root(workspace.root()), next(sink) {}

  void Listen(int port);
  void Handle(const HttpRequest& request, HttpServer::Respond respond);
  // Asks the streams for news now and at every kNewsInterval.
  void TellNews();

  fs::path root;
  ProgressSink* next;
  LiveState live;
  PageContext context;
  asio::thread_pool asking{1};  // waits for the daemon, so that the page need not
  asio::io_context io;
  asio::steady_timer news{io};
  std::optional<HttpServer> http;
  std::thread thread;
};

void PageServer::Impl::Listen(int port) {
  HttpServerOptions options;
  options.port = static_cast<std::uint16_t>(port);
  options.max_body_bytes = kMaxBody;
  http.emplace(io, options, [this](const HttpRequest& request, HttpServer::Respond respond) {
    Handle(request, std::move(respond));
  });
}

void PageServer::Impl::Handle(const HttpRequest& request, HttpServer::Respond respond) {
  const PageAnswer answer = AnswerPageRequest(
      {request.method, request.target, request.Header("host"), request.Header("origin"),
       request.Header("x-colmap-ext-token"), request.body},
      context);
  if (answer.events_since) {
    HttpResponse response = ToResponse(answer, false);
    const auto events = std::make_shared<LiveEvents>(&context, *answer.events_since);
    response.stream = HttpStream{[events] { return events->Next(); }, ": still here\n\n", 10};
    return respond(std::move(response));
  }
  const bool has_inline_script = request.target.starts_with("/pictures.html");
  if (!answer.call) return respond(ToResponse(answer, has_inline_script));
  asio::post(asking, [this, call = *answer.call, respond = std::move(respond)] {
    const HttpResponse response = ToResponse(AskDaemon(root, call), false);
    asio::post(io, [respond, response] { respond(response); });
  });
}

void PageServer::Impl::TellNews() {
  http->Wake();
  news.expires_after(kNewsInterval);
  news.async_wait([this](const boost::system::error_code& error) {
    if (!error) TellNews();
  });
}

PageServer::PageServer(const Workspace& workspace, const PageOptions& options, int port,
                       ProgressSink* next) {
  if (port < 0 || port > 65535) throw UsageError("--serve must be a port, 0 to 65535");
  impl_ = std::make_unique<Impl>(workspace, next);
  impl_->Listen(port);
  impl_->context = {workspace.report(),
                    FindPageAssets(options.assets_path).value_or(fs::path()),
                    fs::absolute(workspace.root()).lexically_normal().filename().string(),
                    this->port(),
                    RandomToken(),
                    &impl_->live};
  impl_->TellNews();
  impl_->thread = std::thread([io = &impl_->io] { io->run(); });
}

PageServer::~PageServer() {
  impl_->io.stop();
  impl_->thread.join();
  impl_->asking.join();
}

int PageServer::port() const { return impl_->http->port(); }

std::string PageServer::url() const { return "http://127.0.0.1:" + std::to_string(port()) + "/"; }

void PageServer::Message(LogLevel level, std::string_view text) {
  if (level > LogLevel::kDebug) impl_->live.Message(level, text);
  if (impl_->next != nullptr) impl_->next->Message(level, text);
}

void PageServer::Progress(std::string_view stage, std::size_t done, std::size_t total) {
  impl_->live.Progress(stage, done, total);
  if (impl_->next != nullptr) impl_->next->Progress(stage, done, total);
}

void PageServer::Finish() { impl_->live.Finish(); }

void PageServer::WaitUntilCancelled(const JobControl& job) {
  while (!job.IsCancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace colmap_ext
