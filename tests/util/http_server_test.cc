#include "colmap_ext/util/http_server.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

// A server on a thread of its own, and a client that sends bytes as they are.
class HttpServerTest : public ::testing::Test {
 protected:
  void Start(HttpServer::Handler handler, HttpServerOptions options = {}) {
    server_.emplace(context_, options, std::move(handler));
    port_ = server_->port();
    thread_ = std::thread([this] { context_.run(); });
  }
  ~HttpServerTest() override {
    asio::post(context_, [this] {
      server_.reset();
      context_.stop();
    });
    if (thread_.joinable()) thread_.join();
  }

  // All that the server sends until it closes.
  std::string Exchange(const std::string& bytes) const {
    asio::io_context io;
    Tcp::socket socket(io);
    socket.connect({asio::ip::address_v4::loopback(), port_});
    boost::system::error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    std::string answer;
    asio::read(socket, asio::dynamic_buffer(answer), error);
    return answer;
  }
  std::string Get(const std::string& target, const std::string& host = "127.0.0.1") const {
    return Exchange("GET " + target + " HTTP/1.1\r\nHost: " + host +
                    "\r\nConnection: close\r\n\r\n");
  }
  static bool Holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  asio::io_context context_;
  std::optional<HttpServer> server_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

void Echo(const HttpRequest& request, const HttpServer::Respond& respond) {
  respond({200, "text/plain", request.method + " " + request.target + " " + request.body});
}

TEST_F(HttpServerTest, AnswersRequests) {
  Start(Echo);
  const std::string answer = Get("/status?x=1", "localhost:8080");
  EXPECT_TRUE(Holds(answer, "200 OK")) << answer;
  EXPECT_TRUE(Holds(answer, "GET /status?x=1 ")) << answer;
  EXPECT_TRUE(Holds(Exchange("POST /a HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: "
                             "3\r\nConnection: close\r\n\r\nabc"),
                    "POST /a abc"));
}

TEST_F(HttpServerTest, KeepsAConnectionForSeveralRequests) {
  Start(Echo);
  const std::string answer = Exchange(
      "GET /first HTTP/1.1\r\nHost: localhost\r\n\r\n"
      "GET /second HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(Holds(answer, "GET /first")) << answer;
  EXPECT_TRUE(Holds(answer, "GET /second")) << answer;
}

TEST_F(HttpServerTest, MayAnswerLater) {
  asio::steady_timer timer(context_);
  Start([&](const HttpRequest& request, const HttpServer::Respond& respond) {
    if (request.target != "/slow") return Echo(request, respond);
    timer.expires_after(std::chrono::milliseconds(100));
    timer.async_wait([respond](auto) { respond({200, "text/plain", "slow"}); });
  });
  std::string slow;
  std::thread waiting([&] { slow = Get("/slow"); });
  EXPECT_TRUE(Holds(Get("/quick"), "GET /quick")) << "others are served meanwhile";
  waiting.join();
  EXPECT_TRUE(Holds(slow, "slow"));
}

TEST_F(HttpServerTest, HeadersOfBothSides) {
  Start([](const HttpRequest& request, const HttpServer::Respond& respond) {
    HttpResponse response{200, "text/plain", request.Header("x-word") + request.Header("x-none")};
    response.headers.emplace_back("X-Answer", "42");
    respond(response);
  });
  const std::string answer =
      Exchange("GET / HTTP/1.1\r\nHost: localhost\r\nX-WORD: hello\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(Holds(answer, "X-Answer: 42\r\n")) << answer;
  EXPECT_TRUE(answer.ends_with("\r\n\r\nhello")) << answer;
}

TEST_F(HttpServerTest, StreamsUntilTheClientLeaves) {
  // Used on the server's thread, which outlives this function.
  const auto news = std::make_shared<std::string>("first\n");
  Start([news](const HttpRequest&, const HttpServer::Respond& respond) {
    HttpResponse response{200, "text/event-stream", ""};
    response.stream = {[news] { return std::exchange(*news, ""); }, "idle\n", 0.05};
    respond(response);
  });
  asio::io_context io;
  Tcp::socket socket(io);
  socket.connect({asio::ip::address_v4::loopback(), port_});
  asio::write(socket, asio::buffer(std::string("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")));
  std::string seen;
  const auto wait_for = [&](const std::string& line) {
    seen.clear();
    while (!Holds(seen, line)) {
      std::string part(100, '\0');
      part.resize(socket.read_some(asio::buffer(part)));
      seen += part;
    }
  };
  wait_for("first\n");
  EXPECT_TRUE(Holds(seen, " 200 OK\r\n"));
  wait_for("idle\nidle\n");
  asio::post(context_, [&] {
    *news = "second\n";
    server_->Wake();
  });
  wait_for("second\n");
}

TEST_F(HttpServerTest, RefusesWhatIsTooLargeNoHttpOrFromAnotherHost) {
  HttpServerOptions options;
  options.max_body_bytes = 10;
  Start(Echo, options);
  EXPECT_TRUE(Holds(Exchange("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 11\r\n\r\n"
                             "12345678901"),
                    " 413 "));
  EXPECT_TRUE(
      Holds(Exchange("GET / HTTP/1.1\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"), " 431 "));
  EXPECT_TRUE(Holds(Exchange("\x01\x02 nonsense\r\n\r\n"), " 400 "));
  EXPECT_TRUE(Holds(Get("/", "evil.example"), " 403 "));
  EXPECT_TRUE(Holds(Get("/fine"), " 200 "));
}

TEST_F(HttpServerTest, ErrorsOfTheHandlerAreAnswered) {
  Start([](const HttpRequest& request, const HttpServer::Respond&) {
    if (request.target == "/usage") throw Error("no such thing");
    throw std::runtime_error("broken");
  });
  const std::string usage = Get("/usage");
  EXPECT_TRUE(Holds(usage, " 400 ")) << usage;
  EXPECT_TRUE(Holds(usage, R"({"error":"no such thing"})")) << usage;
  EXPECT_TRUE(Holds(Get("/other"), " 500 "));
}

TEST_F(HttpServerTest, ListensOnLoopbackOnlyAndNamesAPortThatIsTaken) {
  Start(Echo);
  HttpServerOptions same;
  same.port = port_;
  asio::io_context other;
  try {
    const HttpServer second(other, same, Echo);
    FAIL() << "the port is taken";
  } catch (const Error& error) {
    EXPECT_TRUE(Holds(error.what(), std::to_string(port_))) << error.what();
  }
  // 127.0.0.2 is this machine too, and the server is not there.
  Tcp::socket socket(other);
  boost::system::error_code error;
  socket.connect({asio::ip::make_address("127.0.0.2"), port_}, error);
  EXPECT_TRUE(error) << "it must listen on 127.0.0.1 alone";
}

}  // namespace
}  // namespace colmap_ext
