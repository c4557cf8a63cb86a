#include "flight/api_server.h"

#include <boost/asio/post.hpp>
#include <deque>

#include "colmap_ext/util/http_server.h"
#include "flight/api_call.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kMaxConnections = 32;
constexpr std::size_t kMaxPiece = 8192;     // bytes of events sent at once, about
constexpr std::size_t kKeptEvents = 20000;  // older ones are in the journal
constexpr double kIdleS = 60;
constexpr double kKeepAliveS = 10;

HttpResponse NotStored(HttpResponse response) {
  response.headers.emplace_back("Cache-Control", "no-store");
  return response;
}

HttpResponse Answer(const Json& body) {
  return NotStored(
      {200, "application/json", body.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"});
}

HttpResponse Refusal(int status, const std::string& reason) {
  return NotStored(HttpError(status, reason));
}

}  // namespace

struct ApiServer::Impl : std::enable_shared_from_this<ApiServer::Impl> {
  Impl(asio::io_context* given_io, asio::thread_pool* given_workers, std::string given_token,
       ApiBackend given_backend)
      : io(given_io),
        workers(given_workers),
        token(std::move(given_token)),
        backend(std::move(given_backend)) {}

  void Listen(int port);
  void Handle(const HttpRequest& request, const HttpServer::Respond& respond);
  HttpResponse Ask(const FlightRequest& request) const;
  void LoadThenAsk(FlightRequest request, HttpServer::Respond respond);
  HttpResponse EventsSince(std::size_t since);

  asio::io_context* io;
  asio::thread_pool* workers;
  std::string token;
  ApiBackend backend;
  std::size_t first_event = 0;  // number of events.front()
  std::deque<std::string> events;
  std::optional<HttpServer> http;
};

void ApiServer::Impl::Listen(int port) {
  HttpServerOptions options;
  options.port = static_cast<std::uint16_t>(port);
  options.max_body_bytes = kMaxApiBody;
  options.max_connections = kMaxConnections;
  options.idle_timeout_s = kIdleS;
  http.emplace(*io, options,
               [self = weak_from_this()](const HttpRequest& request, HttpServer::Respond respond) {
                 if (const auto impl = self.lock()) impl->Handle(request, respond);
               });
}

void ApiServer::Impl::Handle(const HttpRequest& request, const HttpServer::Respond& respond) {
  try {
    ApiCall call =
        ParseApiCall({request.method, request.target, request.Header("host"),
                      request.Header("origin"), request.Header("authorization"), request.body},
                     token, backend.mission());
    if (call.kind == ApiCall::Kind::kEvents) return respond(EventsSince(call.since));
    if (call.kind == ApiCall::Kind::kStatus) return respond(Answer(backend.status()));
    if (call.needs_surface) return LoadThenAsk(std::move(call.request), respond);
    respond(Ask(call.request));
  } catch (const ApiError& error) {
    respond(Refusal(error.status(), error.what()));
  } catch (const std::exception& error) {
    respond(Refusal(500, error.what()));
  }
}

HttpResponse ApiServer::Impl::Ask(const FlightRequest& request) const {
  const FlightReply reply = backend.request(request);
  return reply.is_accepted ? Answer(backend.status()) : Refusal(409, reply.reason);
}

// Reading a mesh takes longer than the vehicle may wait for its heartbeat.
void ApiServer::Impl::LoadThenAsk(FlightRequest request, HttpServer::Respond respond) {
  asio::post(*workers, [self = shared_from_this(), loaded = std::move(request),
                        respond = std::move(respond)]() mutable {
    std::string problem;
    try {
      LoadSurface(&loaded);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    asio::post(*self->io,
               [self, loaded = std::move(loaded), respond = std::move(respond), problem] {
                 if (!problem.empty()) return respond(Refusal(400, problem));
                 try {
                   respond(self->Ask(loaded));
                 } catch (const std::exception& error) {
                   respond(Refusal(500, error.what()));
                 }
               });
  });
}

HttpResponse ApiServer::Impl::EventsSince(std::size_t since) {
  HttpStream stream;
  stream.idle_piece = ": waiting\n\n";
  stream.idle_s = kKeepAliveS;
  stream.next_piece = [self = weak_from_this(), next = since]() mutable {
    std::string text;
    const auto impl = self.lock();
    if (!impl) return text;
    next = std::max(next, impl->first_event);
    for (; next < impl->first_event + impl->events.size() && text.size() < kMaxPiece; ++next) {
      const std::string& event = impl->events[next - impl->first_event];
      text += "id: " + std::to_string(next) + "\ndata: " + event + "\n\n";
    }
    return text;
  };
  HttpResponse response = NotStored({200, "text/event-stream", ""});
  response.stream = std::move(stream);
  return response;
}

ApiServer::ApiServer(asio::io_context* io, asio::thread_pool* workers, int port, std::string token,
                     ApiBackend backend)
    : impl_(std::make_shared<Impl>(io, workers, std::move(token), std::move(backend))) {
  impl_->Listen(port);
}

ApiServer::~ApiServer() { impl_->http.reset(); }

int ApiServer::port() const { return impl_->http->port(); }

void ApiServer::Publish(const Json& event) {
  impl_->events.push_back(event.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (impl_->events.size() > kKeptEvents) {
    impl_->events.pop_front();
    ++impl_->first_event;
  }
  impl_->http->Wake();
}

}  // namespace colmap_ext
