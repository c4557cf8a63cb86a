#include "report/page_requests.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "colmap_ext/report/page_server.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

class PageRequestsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(::testing::TempDir()) /
            (std::string("page requests ") +
             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    WriteFileAtomically(root_ / "secret.json", "{}");
    WriteFileAtomically(root_ / "report" / "index.html", "the page");
    WriteFileAtomically(root_ / "report" / "photos" / "a b.jpg", "jpeg");
    WriteFileAtomically(root_ / "report" / ".tmp", "half written");
    context_ = {root_ / "report", {}, "a <title>", 8080, "token", &live_};
  }
  void TearDown() override { fs::remove_all(root_); }

  PageAnswer Get(const std::string& target) const {
    return AnswerPageRequest({"GET", target, "127.0.0.1:8080", "", "", ""}, context_);
  }
  PageAnswer Post(const std::string& target, const std::string& body,
                  const std::string& token = "token",
                  const std::string& origin = "http://127.0.0.1:8080") const {
    return AnswerPageRequest({"POST", target, "127.0.0.1:8080", origin, token, body}, context_);
  }

  fs::path root_;
  LiveState live_;
  PageContext context_;
};

TEST_F(PageRequestsTest, FilesOfThePage) {
  EXPECT_EQ(Get("/").body, "the page");
  EXPECT_EQ(Get("/index.html?x=1").body, "the page");
  EXPECT_EQ(Get("/photos/a%20b.jpg").body, "jpeg");
  EXPECT_EQ(Get("/photos/a%20b.jpg").type, "image/jpeg");
  EXPECT_EQ(Get("/nothing").status, 404);
  EXPECT_EQ(Get("/photos").status, 404);
}

TEST_F(PageRequestsTest, NothingOutsideOfItsFolder) {
  for (const char* target :
       {"/../secret.json", "/%2e%2e/secret.json", "/photos/..%2f..%2fsecret.json", "/.tmp",
        "//etc/passwd", "/%00", "/%zz", "/%2", "secret.json", ""}) {
    const PageAnswer answer = Get(target);
    EXPECT_TRUE(answer.status == 400 || answer.status == 403 || answer.status == 404) << target;
  }
}

TEST_F(PageRequestsTest, ForeignHostsAndOriginsAreRefused) {
  const auto status = [&](const std::string& host, const std::string& origin) {
    return AnswerPageRequest({"GET", "/", host, origin, "", ""}, context_).status;
  };
  EXPECT_EQ(status("localhost:8080", ""), 200);
  EXPECT_EQ(status("localhost:8080", "http://localhost:8080"), 200);
  EXPECT_EQ(status("evil.example:8080", ""), 403);
  EXPECT_EQ(status("127.0.0.1:8081", ""), 403);
  EXPECT_EQ(status("", ""), 403);
  EXPECT_EQ(status("127.0.0.1:8080", "http://evil.example"), 403);
  EXPECT_EQ(status("127.0.0.1:8080", "null"), 403);
}

TEST_F(PageRequestsTest, FlightCommandsNeedTheToken) {
  const PageAnswer pause = Post("/api/flight/pause", "{}");
  ASSERT_TRUE(pause.call);
  EXPECT_EQ(pause.call->method + pause.call->target, "POST/v1/pause");
  EXPECT_EQ(Post("/api/flight/resume", "").call->target, "/v1/resume");
  EXPECT_EQ(Post("/api/flight/abort", "{\"how\": \"land\"}").call->body, "{\"how\":\"land\"}");
  for (const char* body : {"", "{}", "{\"how\": \"crash\"}", "{\"how\": 1}", "[]", "{"}) {
    EXPECT_EQ(Post("/api/flight/abort", body).status, 400) << body;
  }
  EXPECT_EQ(Post("/api/flight/start", "{}").status, 404);
  EXPECT_EQ(Post("/api/flight/pause", "{}", "").status, 403);
  EXPECT_EQ(Post("/api/flight/pause", "{}", "guess").status, 403);
  EXPECT_EQ(Post("/api/flight/pause", "{}", "token", "http://evil.example").status, 403);
  context_.token.clear();
  EXPECT_EQ(Post("/api/flight/pause", "{}", "").status, 403);
  EXPECT_EQ(Get("/api/flight").call->target, "/v1/status");
  EXPECT_EQ(AnswerPageRequest({"DELETE", "/", "127.0.0.1:8080", "", "token", ""}, context_).status,
            405);
}

TEST_F(PageRequestsTest, EventsSayWhatIsNewOnce) {
  live_.Message(LogLevel::kInfo, "one");
  live_.Message(LogLevel::kInfo, "two");
  const PageAnswer answer = Get("/api/events?since=1");
  ASSERT_TRUE(answer.events_since.has_value());
  EXPECT_EQ(answer.type, "text/event-stream");
  EXPECT_EQ(
      AnswerPageRequest({"GET", "/api/events", "evil.example:8080", "", "", ""}, context_).status,
      403);
  LiveEvents events(&context_, *answer.events_since);
  const auto json_of = [](const std::string& event) {
    EXPECT_TRUE(event.starts_with("data: ") && event.ends_with("\n\n")) << event;
    EXPECT_EQ(std::count(event.begin(), event.end(), '\n'), 2) << event;
    return Json::parse(event.substr(6));
  };
  Json json = json_of(events.Next());
  ASSERT_EQ(json["messages"].size(), 1U);
  EXPECT_EQ(json["messages"][0]["text"], "two");
  EXPECT_EQ(json["token"], "token");
  EXPECT_EQ(events.Next(), "");
  live_.Progress("matching", 1, 4);
  json = json_of(events.Next());
  EXPECT_EQ(json["done"], 1);
  EXPECT_TRUE(json["messages"].empty());
  EXPECT_EQ(events.Next(), "");
  live_.Message(LogLevel::kWarning, "three\nlines\nhere");
  json = json_of(events.Next());
  EXPECT_EQ(json["messages"][0]["text"], "three\nlines\nhere");
  WriteFileAtomically(root_ / "report" / "data" / "session.js", "new");
  EXPECT_NE(json_of(events.Next())["version"], json["version"]);
  EXPECT_EQ(events.Next(), "");
}

TEST_F(PageRequestsTest, LiveStateIsToldFromANumberOn) {
  live_.Message(LogLevel::kInfo, "one");
  live_.Message(LogLevel::kWarning, "two \xff");  // not UTF-8
  live_.Progress("matching", 3, 7);
  Json json = Json::parse(Get("/api/live").body);
  EXPECT_EQ(json["messages"].size(), 2U);
  EXPECT_EQ(json["stage"], "matching");
  EXPECT_EQ(json["done"], 3);
  EXPECT_EQ(json["token"], "token");
  EXPECT_TRUE(json["running"].get<bool>());
  live_.Message(LogLevel::kInfo, "three");
  live_.Finish();
  json = Json::parse(Get("/api/live?since=" + json["next"].dump()).body);
  ASSERT_EQ(json["messages"].size(), 1U);
  EXPECT_EQ(json["messages"][0]["text"], "three");
  EXPECT_FALSE(json["running"].get<bool>());
  for (int i = 0; i < 3000; ++i) live_.Message(LogLevel::kInfo, "more");
  json = Json::parse(Get("/api/live?since=1").body);
  EXPECT_EQ(json["messages"].size(), 2000U);
  EXPECT_EQ(json["next"], 3003);
}

TEST_F(PageRequestsTest, BeforeTheFirstIterationThereIsAPage) {
  fs::remove_all(root_ / "report");
  WriteFileAtomically(root_ / "assets" / "page.html", "<h1>{{TITLE}}</h1>");
  WriteFileAtomically(root_ / "assets" / "page.js", "script");
  EXPECT_EQ(Get("/").status, 404);
  context_.assets = root_ / "assets";
  EXPECT_EQ(Get("/").body, "<h1>a &lt;title&gt;</h1>");
  EXPECT_EQ(Get("/assets/page.js").body, "script");
  EXPECT_NE(Get("/data/session.js").body.find("\"iterations\":[]"), std::string::npos);
}

TEST(PageServer, TakesAFreePortAndRefusesATakenOne) {
  const Workspace workspace(::testing::TempDir());
  const PageServer server(workspace, {}, 0, nullptr);
  EXPECT_GT(server.port(), 0);
  EXPECT_EQ(server.url(), "http://127.0.0.1:" + std::to_string(server.port()) + "/");
  EXPECT_THROW(PageServer(workspace, {}, server.port(), nullptr), Error);
  EXPECT_THROW(PageServer(workspace, {}, 70000, nullptr), UsageError);
}

}  // namespace
}  // namespace colmap_ext
