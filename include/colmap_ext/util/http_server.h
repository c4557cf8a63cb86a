// A small HTTP/1.1 server for programs on the same machine (Boost.Beast).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace boost::asio {
class io_context;
}

namespace colmap_ext {

struct HttpRequest {
  std::string method;  // "GET", "POST", …
  std::string target;  // "/status?since=3", as sent
  std::string body;
  std::map<std::string, std::string> headers = {};  // by name in small letters: "host"

  // Of a name in small letters; empty when the request has none.
  std::string Header(const std::string& name) const;
};

// A body without an end, for example server-sent events. The connection closes after it.
struct HttpStream {
  // Called on the io_context's thread: what to send next. Empty: nothing now; it is called again
  // after HttpServer::Wake().
  std::function<std::string()> next_piece;
  // Sent when there was nothing else for so long, to find out whether the client still listens.
  std::string idle_piece;
  double idle_s = 10;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers = {};  // further ones
  std::optional<HttpStream> stream = std::nullopt;                // instead of `body`
};

// A JSON object {"error": reason}.
HttpResponse HttpError(int status, const std::string& reason);

struct HttpServerOptions {
  std::uint16_t port = 0;  // on 127.0.0.1 only; 0: any
  std::size_t max_body_bytes = 64 * 1024;
  std::size_t max_connections = 64;
  double idle_timeout_s = 30;  // of a connection that sends nothing
};

// Answers requests on the io_context's thread. A request that is no HTTP, too large (413) or with a
// Host that is not this machine (403: a web page that a browser was lured to) never reaches the
// handler; an exception of the handler is answered with 400 for a colmap_ext::Error, else 500.
class HttpServer {
 public:
  // Called exactly once, at once or later, on the io_context's thread. It may outlive the server.
  using Respond = std::function<void(HttpResponse)>;
  using Handler = std::function<void(const HttpRequest& request, Respond respond)>;

  // Listens at once. Throws Error naming the port when it is taken. `context` must outlive it.
  HttpServer(boost::asio::io_context& context, const HttpServerOptions& options, Handler handler);
  ~HttpServer();  // closes every connection
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  // Streams that had nothing to send are asked again. On the io_context's thread.
  void Wake();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace colmap_ext
