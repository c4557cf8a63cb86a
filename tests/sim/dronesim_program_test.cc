// The program itself, as a child process.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "drone_client.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::HttpExchange;
using test::HttpGetJson;
using test::ScratchFolder;
using test::UdpPeer;

// Ends with the test.
class Dronesim {
 public:
  explicit Dronesim(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), COLMAP_EXT_DRONESIM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    EXPECT_EQ(::posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    output_ = ends[0];
  }
  ~Dronesim() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    ::close(output_);
  }
  Dronesim(const Dronesim&) = delete;
  Dronesim& operator=(const Dronesim&) = delete;

  std::string ReadLine() {
    std::string line;
    for (char c = 0; ::read(output_, &c, 1) == 1 && c != '\n';) line += c;
    return line;
  }
  void Signal(int signal) { ::kill(pid_, signal); }
  int WaitForExit() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

class DronesimTest : public ::testing::Test {
 protected:
  std::vector<std::string> Arguments(const std::string& personality) {
    return {"--scene",
            "boxes",
            "--texel_scale",
            "16",
            "--personality",
            personality,
            "--speed",
            "20",
            "--connection",
            peer_.Url(),
            "--output_path",
            (folder_ / "out").string(),
            "--Renderer.ambient_rays",
            "0"};
  }
  UdpPeer peer_;
  ScratchFolder folder_{"program"};
};

TEST_F(DronesimTest, StartsBeatsAndEndsOnRequest) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Dronesim drone(Arguments(signal == SIGTERM ? "px4" : "ardupilot"));
    const Json ready = Json::parse(drone.ReadLine(), nullptr, false);
    ASSERT_TRUE(ready.is_object());
    EXPECT_GT(ready["http_port"], 0);
    EXPECT_EQ(ready["speed"], 20);
    EXPECT_TRUE(peer_.Hears<MavHeartbeat>(10));
    const Json status = HttpGetJson(ready["http_port"], "/status");
    EXPECT_EQ(status["personality"], signal == SIGTERM ? "px4" : "ardupilot");
    EXPECT_EQ(status["armed"], false);
    drone.Signal(signal);
    EXPECT_EQ(drone.WaitForExit(), 0);
  }
}

TEST_F(DronesimTest, CrashesOnRequest) {
  Dronesim drone(Arguments("px4"));
  const Json ready = Json::parse(drone.ReadLine(), nullptr, false);
  ASSERT_TRUE(ready.is_object());
  HttpExchange(ready["http_port"], "POST", "/faults", R"({"crash": true})");
  EXPECT_EQ(drone.WaitForExit(), 70);
}

TEST_F(DronesimTest, WrongUsageIsOneLineAndCodeTwo) {
  const std::vector<std::vector<std::string>> cases = {
      {"--scene", "church"},
      {"--output_path", (folder_ / "x").string()},
      {"--scene", "church", "--output_path", "/tmp/x", "--personality", "inav"},
      {"--scene", "church", "--output_path", "/tmp/x", "--speed", "0"},
      {"--no_such_option", "1"}};
  for (const auto& arguments : cases) {
    Dronesim drone(arguments);
    const std::string line = drone.ReadLine();
    EXPECT_EQ(line.find("colmap_ext_dronesim: "), 0U) << line;
    EXPECT_EQ(drone.ReadLine(), "");
    EXPECT_EQ(drone.WaitForExit(), 2) << line;
  }
}

}  // namespace
}  // namespace colmap_ext
