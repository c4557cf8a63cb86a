// The API: what it takes and refuses, over real sockets, too.
#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/write.hpp>
#include <random>
#include <thread>

#include "colmap_ext/flight/flight_client.h"
#include "colmap_ext/util/file_lock.h"
#include "colmap_ext/util/files.h"
#include "flight/api_call.h"
#include "flight/api_server.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

namespace asio = boost::asio;

const std::string kToken = "0123456789abcdef";

ApiRequest Get(const std::string& target) {
  return {"GET", target, "127.0.0.1:80", "", "Bearer " + kToken, ""};
}
ApiRequest Post(const std::string& target, const std::string& body) {
  return {"POST", target, "localhost", "", "Bearer " + kToken, body};
}

int StatusFor(const ApiRequest& request) {
  try {
    ParseApiCall(request, kToken, FlightMission());
    return 200;
  } catch (const ApiError& error) {
    EXPECT_STRNE(error.what(), "");
    return error.status();
  }
}

TEST(ApiCall, TakesWhatTheDocumentSays) {
  EXPECT_EQ(ParseApiCall(Get("/v1/status"), kToken, {}).kind, ApiCall::Kind::kStatus);
  EXPECT_EQ(ParseApiCall(Get("/v1/events?since=12"), kToken, {}).since, 12U);
  const ApiCall abort = ParseApiCall(Post("/v1/abort", R"({"how":"land"})"), kToken, {});
  EXPECT_EQ(abort.request.kind, FlightRequest::Kind::kAbort);
  EXPECT_TRUE(abort.request.land);
  const ApiCall load =
      ParseApiCall(Post("/v1/mission", R"({"origin":{"lat":1,"lon":2,"height_m":3},"vouched":true,
        "transit_z_m":20,"stops":[{"position_enu_m":[1,2,3],"yaw_deg":90,"pitch_deg":-30,
        "view_id":4,"photo":"a.jpg"}]})"),
                   kToken, {});
  EXPECT_EQ(load.request.mission.stops.size(), 1U);
  EXPECT_FALSE(load.needs_surface);
}

TEST(ApiCall, RefusesStrangers) {
  ApiRequest request = Get("/v1/status");
  request.authorization = "Bearer wrong";
  EXPECT_EQ(StatusFor(request), 401);
  request = Get("/v1/status");
  request.origin = "https://example.com";
  EXPECT_EQ(StatusFor(request), 403) << "a web page";
  request = Get("/v1/status");
  request.host = "example.com";
  EXPECT_EQ(StatusFor(request), 403) << "a name that was bent to this machine";
}

TEST(ApiCall, BadBodiesAre400WithAReason) {
  for (const char* body : {"{", "[]", "7", "{\"how\":\"up\"}", "{\"how\":7}", "{}", "\"x\"",
                           "{\"how\":\"rtl\"", "nul"}) {
    EXPECT_EQ(StatusFor(Post("/v1/abort", body)), 400) << body;
  }
  EXPECT_EQ(StatusFor(Post("/v1/mission", "{}")), 400);
  EXPECT_EQ(StatusFor(Post("/v1/append", R"({"stops":[]})")), 400);
  EXPECT_EQ(StatusFor(Post("/v1/pause", std::string(1000, '[') + std::string(1000, ']'))), 400);
  EXPECT_EQ(StatusFor(Get("/v1/nothing")), 404);
  EXPECT_EQ(StatusFor(Get("/v1/start")), 405);
  EXPECT_EQ(StatusFor(Post("/v1/status", "")), 405);
  EXPECT_EQ(StatusFor(Get("/v1/events?since=x")), 400);
  EXPECT_EQ(StatusFor(Post("/v1/mission", std::string(kMaxApiBody + 1, ' '))), 413);
}

// Damaged bodies of every kind: an answer, never a crash.
TEST(ApiCall, SurvivesDamagedBodies) {
  FlightMission mission;
  mission.is_vouched = true;
  mission.transit_z_m = 20;
  mission.stops = {{{1, 2, 3}, {1, 1}, 3, "a.jpg"}};
  const std::string good = MissionToJson(mission).dump();
  std::mt19937 random(11);
  int accepted = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string body = good;
    for (int k = 0; k < 1 + i % 4; ++k) body[random() % body.size()] = static_cast<char>(random());
    if (i % 3 == 0) body.resize(random() % body.size());
    const int status = StatusFor(Post("/v1/mission", body));
    EXPECT_TRUE(status == 200 || status == 400) << status;
    accepted += status == 200 ? 1 : 0;
  }
  EXPECT_LT(accepted, 1500);
}

class Server : public ::testing::Test {
 protected:
  Server() {
    ApiBackend backend;
    backend.status = [] { return Json({{"state", "HOLD"}}); };
    backend.request = [this](const FlightRequest& request) {
      requests_.push_back(request.kind);
      return FlightReply{request.kind != FlightRequest::Kind::kStart, "not now"};
    };
    backend.mission = [this]() -> const FlightMission& { return mission_; };
    server_ = std::make_unique<ApiServer>(&io_, &workers_, 0, kToken, backend);
    thread_ = std::jthread([this] { io_.run(); });
  }
  ~Server() override {
    io_.stop();
    thread_.join();
    server_.reset();
  }

  FlightClient Client() const { return FlightClient({server_->port(), 1, kToken}); }

  // Sends bytes as they are; what comes back until the server closes.
  std::string Raw(const std::string& bytes) const {
    asio::io_context io;
    asio::ip::tcp::socket socket(io);
    socket.connect(
        {asio::ip::address_v4::loopback(), static_cast<unsigned short>(server_->port())});
    boost::system::error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    socket.shutdown(asio::ip::tcp::socket::shutdown_send, error);
    std::string answer;
    asio::read(socket, asio::dynamic_buffer(answer), error);
    return answer;
  }

  asio::io_context io_;
  asio::thread_pool workers_{1};
  FlightMission mission_;
  std::vector<FlightRequest::Kind> requests_;
  std::unique_ptr<ApiServer> server_;
  std::jthread thread_;
};

TEST_F(Server, AnswersTheClient) {
  EXPECT_EQ(Client().Status()["state"], "HOLD");
  Client().Pause();
  EXPECT_EQ(requests_, std::vector{FlightRequest::Kind::kPause});
  ExpectError([&] { Client().Start(); }, {"refuses", "not now"});
  ExpectError([&] { FlightClient({server_->port(), 1, "x"}).Pause(); }, {"token"});
  EXPECT_EQ(requests_.size(), 2U);
}

TEST_F(Server, ASurfaceThatCannotBeReadIsABadRequest) {
  FlightMission mission;
  mission.surface_path = "/nowhere/surface.ply";
  ExpectError([&] { Client().Load(mission); }, {"surface.ply"});
  EXPECT_TRUE(requests_.empty());
}

TEST_F(Server, EventsComeInOrderEarlierOnesToo) {
  asio::post(io_, [this] {
    for (int i = 0; i < 5; ++i) server_->Publish({{"n", i}});
  });
  asio::post(io_, [this] {
    for (int i = 5; i < 8; ++i) server_->Publish({{"n", i}});
  });
  std::vector<int> seen;
  Client().Watch(
      2,
      [&](const Json& event) {
        seen.push_back(event["n"].get<int>());
        return seen.back() != 7;
      },
      [] { return true; });
  EXPECT_EQ(seen, (std::vector{2, 3, 4, 5, 6, 7}));
}

TEST_F(Server, RubbishIsAnsweredOrDropped) {
  EXPECT_TRUE(Raw("rubbish\r\n\r\n").starts_with("HTTP/1.1 400"));
  EXPECT_TRUE(Raw("GET / HTTP/1.1\r\nX: " + std::string(20000, 'a') + "\r\n\r\n")
                  .starts_with("HTTP/1.1 431"));
  EXPECT_TRUE(
      Raw("POST /v1/mission HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n")
          .starts_with("HTTP/1.1 413"));
  EXPECT_EQ(Client().Status()["state"], "HOLD") << "still there";
}

// On every other address of this machine nobody listens.
TEST_F(Server, ListensOnLoopbackOnly) {
  asio::io_context io;
  asio::ip::tcp::socket socket(io);
  boost::system::error_code error;
  socket.connect(
      {asio::ip::make_address_v4("127.0.0.2"), static_cast<unsigned short>(server_->port())},
      error);
  EXPECT_TRUE(error) << "another loopback address stands for any other interface";
}

TEST(DaemonAddress, ComesBackAndIsPrivate) {
  const TestFolder folder;
  WriteDaemonAddress({4711, static_cast<int>(getpid()), "secret"}, folder.path());
  auto lock = std::make_unique<FileLock>(DaemonLockPath(folder.path()), "busy");
  const auto address = FindDaemon(folder.path());
  ASSERT_TRUE(address);
  EXPECT_EQ(address->port, 4711);
  EXPECT_EQ(address->token, "secret");
  using std::filesystem::perms;
  const perms mode = std::filesystem::status(DaemonAddressPath(folder.path())).permissions();
  EXPECT_EQ(mode & (perms::group_all | perms::others_all), perms::none);
  lock.reset();
  WriteFileAtomically(DaemonLockPath(folder.path()), "");  // as a killed one leaves it
  EXPECT_FALSE(FindDaemon(folder.path())) << "its daemon is gone, whoever has that number now";
}

}  // namespace
}  // namespace colmap_ext
