#include "colmap_ext/report/page_server.h"

#include <openssl/rand.h>

// Before Asio: its awaitable.hpp of Boost 1.74 uses std::exchange and does not include it.
#include <utility>
// Asio and Beast.
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <thread>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "report/page_requests.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using asio::ip::tcp;

using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::size_t kMaxBody = 4096;  // bytes
constexpr std::size_t kMaxHeader = 8192;
constexpr std::size_t kMaxConnections = 64;
constexpr auto kIdle = std::chrono::seconds(30);
constexpr auto kDaemonTimeout = std::chrono::seconds(3);

// Completion token: what went wrong goes into `error`.
auto Into(boost::system::error_code& error) {
  return asio::redirect_error(asio::use_awaitable, error);
}

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

std::string HeaderOf(const Request& request, beast::string_view name) {
  const auto found = request.find(name);
  return found == request.end() ? "" : std::string(found->value());
}

PageRequest Simplify(const Request& request) {
  return {std::string(request.method_string()),
          std::string(request.target()),
          HeaderOf(request, "Host"),
          HeaderOf(request, "Origin"),
          HeaderOf(request, "X-Colmap-Ext-Token"),
          request.body()};
}

// The static page has its script inside; frames are refused, so that nobody lays a button over
// ours.
constexpr const char* kPolicy =
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
constexpr const char* kPolicyWithInlineScript =
    "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
    "script-src 'unsafe-inline'; connect-src 'none'; frame-ancestors 'none'";

Response ToResponse(const PageAnswer& answer, bool has_inline_script) {
  Response response(static_cast<http::status>(answer.status), 11);
  response.set(http::field::content_type, answer.type);
  response.set(http::field::cache_control, "no-cache");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Content-Security-Policy", has_inline_script ? kPolicyWithInlineScript : kPolicy);
  response.body() = answer.body;
  response.prepare_payload();
  return response;
}

struct DaemonAddress {
  int port = 0;
  std::string token;
};

// Where the workspace's flight daemon listens (docs/flight_api.md); nullopt: it has none.
std::optional<DaemonAddress> FindDaemon(const fs::path& workspace) {
  const fs::path path = workspace / "flightd.json";
  if (!fs::exists(path)) return std::nullopt;
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  return DaemonAddress{root["port"].Integer(), root["token"].Text()};
}

// The daemon's answer; nullopt: nobody listens there, or it takes too long.
asio::awaitable<std::optional<PageAnswer>> AskDaemon(DaemonAddress address, DaemonCall call) {
  beast::tcp_stream stream(co_await asio::this_coro::executor);
  boost::system::error_code error;
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(),
                               static_cast<unsigned short>(address.port));
  stream.expires_after(kDaemonTimeout);
  co_await stream.async_connect(endpoint, Into(error));
  if (error) co_return std::nullopt;
  Request request(http::string_to_verb(call.method), call.target, 11);
  request.set(http::field::host, "127.0.0.1:" + std::to_string(address.port));
  request.set(http::field::authorization, "Bearer " + address.token);
  request.set(http::field::content_type, "application/json");
  request.keep_alive(false);
  request.body() = call.body;
  request.prepare_payload();
  co_await http::async_write(stream, request, Into(error));
  if (error) co_return std::nullopt;
  beast::flat_buffer buffer;
  Response response;
  co_await http::async_read(stream, buffer, response, Into(error));
  if (error) co_return std::nullopt;
  co_return PageAnswer{static_cast<int>(response.result_int()), "application/json", response.body(),
                       std::nullopt};
}

// GET without a daemon is no error: the page asks to find out.
asio::awaitable<PageAnswer> Forward(fs::path workspace, DaemonCall call) {
  const PageAnswer nobody =
      call.method == "GET"
          ? PageAnswer{200, "application/json", "null\n", std::nullopt}
          : PageAnswer{502, "application/json",
                       "{\"error\": \"the flight daemon does not answer\"}\n", std::nullopt};
  std::optional<DaemonAddress> address;
  try {
    address = FindDaemon(workspace);
  } catch (const Error&) {  // half written, or not a daemon's
  }
  if (!address) co_return nobody;
  const std::optional<PageAnswer> answer = co_await AskDaemon(*address, std::move(call));
  co_return answer.value_or(nobody);
}

}  // namespace

struct PageServer::Impl {
  Impl(const Workspace& workspace, ProgressSink* sink)
      : root(workspace.root()), next(sink), acceptor(io) {}

  void Listen(int port);
  asio::awaitable<void> Accept();
  asio::awaitable<void> Serve(tcp::socket socket);
  asio::awaitable<Response> Answer(const Request& request);

  fs::path root;
  ProgressSink* next;
  LiveState live;
  PageContext context;
  asio::io_context io;
  tcp::acceptor acceptor;
  std::size_t connections = 0;
  std::thread thread;
};

void PageServer::Impl::Listen(int port) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), static_cast<unsigned short>(port));
  boost::system::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(32, error);
  if (error) {
    throw Error("--serve " + std::to_string(port) +
                ": cannot listen on 127.0.0.1: " + error.message() + "; choose another port");
  }
}

asio::awaitable<void> PageServer::Impl::Accept() {
  while (acceptor.is_open()) {
    boost::system::error_code error;
    tcp::socket socket = co_await acceptor.async_accept(Into(error));
    if (error == asio::error::operation_aborted) co_return;
    if (error || connections >= kMaxConnections) continue;
    asio::co_spawn(io, Serve(std::move(socket)), asio::detached);
  }
}

asio::awaitable<void> PageServer::Impl::Serve(tcp::socket socket) {
  ++connections;
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer;
  boost::system::error_code error;
  while (!error) {
    http::request_parser<http::string_body> parser;
    parser.body_limit(kMaxBody);
    parser.header_limit(kMaxHeader);
    stream.expires_after(kIdle);
    co_await http::async_read(stream, buffer, parser, Into(error));
    if (error) break;
    Response response = co_await Answer(parser.get());
    response.keep_alive(parser.get().keep_alive());
    stream.expires_after(kIdle);
    co_await http::async_write(stream, response, Into(error));
    if (!response.keep_alive()) break;
  }
  boost::system::error_code ignored;
  stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
  --connections;
}

asio::awaitable<Response> PageServer::Impl::Answer(const Request& request) {
  PageAnswer answer = AnswerPageRequest(Simplify(request), context);
  if (answer.call) {
    DaemonCall call = std::move(*answer.call);
    answer = co_await Forward(root, std::move(call));
  }
  co_return ToResponse(answer, request.target().starts_with("/pictures.html"));
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
  asio::co_spawn(impl_->io, impl_->Accept(), asio::detached);
  impl_->thread = std::thread([io = &impl_->io] { io->run(); });
}

PageServer::~PageServer() {
  impl_->io.stop();
  impl_->thread.join();
}

int PageServer::port() const { return impl_->acceptor.local_endpoint().port(); }

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
