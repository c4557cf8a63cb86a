#include "colmap_ext/flight/picture_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "colmap_ext/mavlink/codec.h"
#include "colmap_ext/mavlink/ftp_server.h"
#include "colmap_ext/mavlink/lossy_link.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using boost::asio::ip::tcp;
using Bytes = std::vector<std::uint8_t>;

// Answers one request with what `serve` writes, in a thread of its own.
class OneAnswer {
 public:
  using Serve = std::function<void(tcp::socket*, const std::string& request)>;
  explicit OneAnswer(Serve serve)
      : acceptor_(io_, tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0)),
        thread_([this, serve = std::move(serve)] {
          boost::system::error_code error;
          tcp::socket socket = acceptor_.accept(error);
          if (error) return;
          boost::asio::streambuf request;
          boost::asio::read_until(socket, request, "\r\n\r\n", error);
          const auto data = request.data();
          serve(&socket, {boost::asio::buffers_begin(data), boost::asio::buffers_end(data)});
        }) {}
  ~OneAnswer() { thread_.join(); }
  std::string Url(const std::string& path = "/pictures/7.jpg") const {
    return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + path;
  }

 private:
  boost::asio::io_context io_;
  tcp::acceptor acceptor_;
  std::thread thread_;
};

void Write(tcp::socket* socket, const std::string& text) {
  boost::system::error_code ignored;
  boost::asio::write(*socket, boost::asio::buffer(text), ignored);
}

OneAnswer::Serve Text(const std::string& text) {
  return [text](tcp::socket* socket, const std::string&) { Write(socket, text); };
}

std::string Header(std::size_t length) {
  return "HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: " +
         std::to_string(length) + "\r\n\r\n";
}

std::string FailureOf(const std::string& url, const HttpCallOptions& options = {}) {
  try {
    GetPictureByHttp(url, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

void ExpectFailure(const OneAnswer::Serve& serve, const std::string& part,
                   const HttpCallOptions& options = {}) {
  const OneAnswer server(serve);
  const std::string url = server.Url();
  const std::string failure = FailureOf(url, options);
  EXPECT_NE(failure.find(part), std::string::npos) << failure;
  EXPECT_NE(failure.find(url), std::string::npos) << failure;
  EXPECT_EQ(failure.find('\n'), std::string::npos);
}

TEST(PictureByHttp, ComesWholeAndTheRequestIsRight) {
  const std::string picture(300000, '\xD8');
  std::string request;
  {
    const OneAnswer server([&](tcp::socket* socket, const std::string& text) {
      request = text;
      Write(socket, Header(picture.size()) + picture);
    });
    EXPECT_EQ(GetPictureByHttp(server.Url("/low/7.jpg?size=low"), {}), picture);
  }
  EXPECT_TRUE(request.starts_with("GET /low/7.jpg?size=low HTTP/1.1\r\n")) << request;
  EXPECT_NE(request.find("Host: 127.0.0.1:"), std::string::npos);
}

TEST(PictureByHttp, ChunkedAnswersAreUnderstood) {
  const OneAnswer server(Text(
      "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n2\r\nde\r\n0\r\n\r\n"));
  EXPECT_EQ(GetPictureByHttp(server.Url(), {}), "abcde");
}

TEST(PictureByHttp, ATransferThatBreaksOffIsNoPicture) {
  ExpectFailure(Text(Header(1000) + std::string(999, 'x')), "broke off after 999 bytes");
  ExpectFailure(Text("HTTP/1.1 200 OK\r\nContent-Le"), "broke off after 0 bytes");
  ExpectFailure(Text("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nab"),
                "broke off after 2 bytes");
}

TEST(PictureByHttp, WhatTheServerRefusesIsReportedWithItsNumber) {
  ExpectFailure(Text("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"), "404 Not Found");
  ExpectFailure(Text("HTTP/1.1 503 Busy\r\nContent-Length: 4\r\n\r\nwait"), "503 Busy");
  ExpectFailure(Text("HTTP/1.1 302 Found\r\nLocation: /x\r\nContent-Length: 0\r\n\r\n"), "302");
  ExpectFailure(Text("220 FTP ready\r\n\r\n"), "bad version");
}

TEST(PictureByHttp, ASilentServerIsGivenUpASlowOneIsNot) {
  HttpCallOptions options;
  options.silence_timeout_s = 1;
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(250)); };
  ExpectFailure(
      [&](tcp::socket* socket, const std::string&) {
        Write(socket, Header(100) + "half");
        for (int i = 0; i < 6; ++i) pause();
      },
      "no answer in time, after 4 bytes", options);
  const OneAnswer slow([&](tcp::socket* socket, const std::string&) {
    Write(socket, Header(8));
    for (int i = 0; i < 8; ++i) {
      pause();
      Write(socket, "x");
    }
  });
  EXPECT_EQ(GetPictureByHttp(slow.Url(), options), "xxxxxxxx");
}

TEST(PictureByHttp, EvenASlowServerHasToEnd) {
  HttpCallOptions options;
  options.total_timeout_s = 0.4;
  ExpectFailure(
      [](tcp::socket* socket, const std::string&) {
        Write(socket, Header(1000));
        for (int i = 0; i < 20; ++i) {
          std::this_thread::sleep_for(std::chrono::milliseconds(40));
          Write(socket, "x");
        }
      },
      "no answer in time", options);
}

TEST(PictureByHttp, APictureThatIsTooLongIsRefused) {
  HttpCallOptions options;
  options.max_bytes = 1000;
  ExpectFailure(Text(Header(1001) + std::string(1001, 'x')), "more than the allowed 1000 bytes",
                options);
}

TEST(PictureByHttp, NobodyThereIsAnError) {
  std::string url;
  {
    boost::asio::io_context io;
    const tcp::acceptor acceptor(io, tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0));
    url = "http://127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()) + "/a";
  }
  EXPECT_NE(FailureOf(url).find("refused"), std::string::npos);
}

TEST(PictureByHttp, OnlyHttpAddressesAreTaken) {
  for (const char* url :
       {"", "ftp://a/b", "https://a/b", "http://", "http:///a", "http://a:x/b", "http://a:/b",
        "http://a:80:80000000/b", "http://a/b\r\nX: y", "http://a b/c", "file:///etc/passwd"}) {
    EXPECT_NE(FailureOf(url).find("not an"), std::string::npos) << url;
  }
  HttpCallOptions options;
  options.silence_timeout_s = 0;
  EXPECT_THROW(GetPictureByHttp("http://127.0.0.1:1/", options), UsageError);
}

CaptureFile File(const std::string& name, double time_s, std::optional<std::int64_t> number) {
  return {name, time_s, number};
}

using Match = std::vector<std::optional<std::size_t>>;

TEST(CaptureFolder, NumbersDecideWhereTimesAreNearEachOther) {
  std::vector<ReportedCapture> captures;
  std::vector<CaptureFile> files;
  for (int i = 0; i < 20; ++i) {
    captures.push_back({i, 1000.0 + i});
    // The camera writes late and unevenly, and began to number at 9042; one file is missing.
    if (i != 7) files.push_back(File("a", 1000.9 + i + 0.3 * (i % 3), 9042 + i));
  }
  const Match match = MatchCaptureFiles(captures, files, {});
  for (std::size_t i = 0; i < 20; ++i) {
    if (i == 7) {
      EXPECT_FALSE(match[i].has_value());
    } else {
      EXPECT_EQ(match[i], i < 7 ? i : i - 1) << i;
    }
  }
}

TEST(CaptureFolder, AnOldFileWithTheRightNumberIsNotTaken) {
  const std::vector<ReportedCapture> captures = {{0, 1000}, {1, 1010}, {2, 1020}};
  const std::vector<CaptureFile> files = {File("old", 10, 2), File("a", 1000.5, 0),
                                          File("b", 1010.5, 1)};
  EXPECT_EQ(MatchCaptureFiles(captures, files, {}), (Match{1, 2, std::nullopt}));
}

TEST(CaptureFolder, WithoutNumbersTimeDecidesWhenItIsClear) {
  const std::vector<ReportedCapture> captures = {{0, 1000}, {1, 1010}, {2, 1020}, {3, 1020.4}};
  const std::vector<CaptureFile> files = {File("x", 1000.5, {}), File("y", 1011, {}),
                                          File("z", 1020.2, {})};
  EXPECT_EQ(MatchCaptureFiles(captures, files, {}), (Match{0, 1, std::nullopt, std::nullopt}))
      << "the last file may be either of two captures";
}

TEST(CaptureFolder, AWrongClockIsToldByOption) {
  const std::vector<ReportedCapture> captures = {{0, 5000}, {1, 5010}};
  const std::vector<CaptureFile> files = {File("a", 1400, 4), File("b", 1410, 5)};
  EXPECT_EQ(MatchCaptureFiles(captures, files, {}), (Match{std::nullopt, std::nullopt}));
  CaptureFolderOptions options;
  options.clock_offset_s = 3600;
  EXPECT_EQ(MatchCaptureFiles(captures, files, options), (Match{0, 1}));
}

TEST(CaptureFolder, NoFileIsTwoCaptures) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 200; ++round) {
    std::vector<ReportedCapture> captures;
    std::vector<CaptureFile> files;
    for (int i = 0; i < 12; ++i) {
      captures.push_back(
          {static_cast<std::int64_t>(random() % 10), static_cast<double>(random() % 20)});
      std::optional<std::int64_t> number;
      if (random() % 2 == 0) number = static_cast<std::int64_t>(random() % 10);
      files.push_back(File("a", static_cast<double>(random() % 20), number));
    }
    std::vector<int> uses(files.size(), 0);
    for (const auto& file : MatchCaptureFiles(captures, files, {})) {
      if (!file) continue;
      EXPECT_EQ(++uses.at(*file), 1);
    }
  }
}

class PictureFolders : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("pictures_" + std::to_string(std::random_device{}()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  void Put(const std::string& name, const Bytes& content = Bytes(10, 'x')) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()),
               static_cast<std::streamsize>(content.size()));
  }
  static double NowS() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  fs::path folder_;
};

TEST_F(PictureFolders, FilesAreListedWithTimeAndNumber) {
  Put("100MEDIA/DSC_0042.JPG");
  Put("DJI_20240102_0007_V.jpg");
  Put("nameless.jpg");
  Put("1234567890123456.png");
  Put("notes.txt");
  Put("empty.jpg", {});
  const auto files = ListCaptureFiles(folder_, {}, NowS() + 10);
  ASSERT_EQ(files.size(), 4U);
  std::map<std::string, std::optional<std::int64_t>> numbers;
  for (const CaptureFile& file : files) {
    numbers[file.path.filename()] = file.number;
    EXPECT_NEAR(file.time_s, NowS(), 5);
  }
  EXPECT_EQ(numbers["DSC_0042.JPG"], 42);
  EXPECT_EQ(numbers["DJI_20240102_0007_V.jpg"], 7);
  EXPECT_EQ(numbers["nameless.jpg"], std::nullopt);
  EXPECT_EQ(numbers["1234567890123456.png"], std::nullopt) << "no counter has so many digits";
}

TEST_F(PictureFolders, AFileThatMayStillBeWrittenWaits) {
  Put("a_1.jpg");
  EXPECT_TRUE(ListCaptureFiles(folder_, {}, NowS()).empty());
  EXPECT_EQ(ListCaptureFiles(folder_, {}, NowS() + 1.5).size(), 1U);
  // Copied with its old date: it is new all the same.
  fs::last_write_time(folder_ / "a_1.jpg",
                      fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_TRUE(ListCaptureFiles(folder_, {}, NowS()).empty());
}

TEST_F(PictureFolders, AFolderThatIsNotThereYetIsEmpty) {
  EXPECT_TRUE(ListCaptureFiles(folder_ / "card", {}, NowS()).empty());
  CaptureFolderOptions options;
  options.tolerance_s = 0;
  EXPECT_THROW(ListCaptureFiles(folder_, options, NowS()), UsageError);
}

// A queue, a server of a folder and a link between them.
class FtpPictures : public PictureFolders {
 protected:
  std::vector<FtpPictureQueue::Result> Run(FtpPictureQueue* queue, double loss,
                                           const std::function<void()>& each = nullptr) {
    LossyLinkOptions link;
    link.loss = loss;
    LossyLink up(link, 1);
    LossyLink down(link, 2);
    MavFtpServer server(folder_, {});
    MavParser parser;
    std::vector<FtpPictureQueue::Result> results;
    const auto answer = [&](const std::vector<MavFileTransferProtocol>& messages) {
      for (const auto& message : messages) down.Send(PackMav(message, {1, 100, 0}), now_s_);
    };
    const double end_s = now_s_ + 300;
    for (; now_s_ < end_s; now_s_ += 0.002) {
      for (const auto& message : queue->Poll(now_s_)) {
        EXPECT_EQ(message.target_component, 100);
        up.Send(PackMav(message, {255, 190, 0}), now_s_);
      }
      up.Deliver(now_s_, [&](std::span<const std::uint8_t> packet) {
        parser.Feed(packet, [&](const MavFrame& frame) {
          answer(server.Receive(*UnpackMav<MavFileTransferProtocol>(frame), frame, now_s_));
        });
      });
      answer(server.Poll(now_s_));
      down.Deliver(now_s_, [&](std::span<const std::uint8_t> packet) {
        parser.Feed(packet, [&](const MavFrame& frame) {
          queue->Receive(*UnpackMav<MavFileTransferProtocol>(frame), frame, now_s_);
        });
      });
      if (each) each();
      for (auto& result : queue->TakeResults()) results.push_back(std::move(result));
      if (queue->Waiting() == 0 && !queue->NextTimeS()) break;
    }
    return results;
  }
  static FtpPictureQueue::Request Ask(std::uint64_t id, const std::string& path, bool full) {
    return {id, 1, 100, path, full};
  }
  double now_s_ = 50;
};

TEST_F(FtpPictures, LowResolutionsComeFirstAndAllComeWhole) {
  std::mt19937_64 random(1);
  std::map<std::uint64_t, Bytes> contents;
  FtpPictureQueue queue({}, 77, 3);
  for (std::uint64_t i = 0; i < 6; ++i) {
    for (const bool full : {true, false}) {
      Bytes content(full ? 20000 + i : 5000 + i);
      for (std::uint8_t& byte : content) byte = static_cast<std::uint8_t>(random());
      const std::string name = (full ? "full/" : "low/") + std::to_string(i) + ".jpg";
      Put(name, content);
      const std::uint64_t id = 2 * i + (full ? 1 : 0);
      contents[id] = content;
      queue.Add(Ask(id, name, full));
    }
  }
  const auto results = Run(&queue, 0.2);
  ASSERT_EQ(results.size(), 12U);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].failure, "");
    EXPECT_EQ(results[i].bytes, contents[results[i].id]);
    EXPECT_EQ(results[i].id % 2, i < 6 ? 0U : 1U) << "low before full";
  }
}

TEST_F(FtpPictures, AFailureIsReportedOnceAfterAllAttempts) {
  Put("b.jpg");
  FtpPictureQueue queue({}, 0, 3);
  queue.Add(Ask(1, "none.jpg", false));
  queue.Add(Ask(2, "b.jpg", false));
  queue.Add(Ask(3, "", false));
  const auto results = Run(&queue, 0);
  ASSERT_EQ(results.size(), 3U);
  std::map<std::uint64_t, std::string> failures;
  for (const auto& result : results) failures[result.id] = result.failure;
  EXPECT_NE(failures[1].find("file not found"), std::string::npos);
  EXPECT_EQ(failures[2], "");
  EXPECT_NE(failures[3].find("path"), std::string::npos);
}

TEST_F(FtpPictures, WhatComesFromAnotherComponentIsNotForIt) {
  FtpPictureQueue queue({}, 0, 1);
  queue.Add(Ask(1, "a.jpg", false));
  ASSERT_EQ(queue.Poll(now_s_).size(), 1U);
  MavFtpPayload nak;
  nak.sequence = 1025;
  nak.opcode = MavFtpOpcode::kNak;
  nak.request_opcode = MavFtpOpcode::kOpenFileRo;
  nak.data = {10};
  nak.size = 1;
  const MavFileTransferProtocol message = EncodeMavFtp(nak, 255, 190);
  queue.Receive(message, MakeMavFrame(message, {1, 1, 0}), now_s_);
  queue.Poll(now_s_);
  EXPECT_TRUE(queue.TakeResults().empty());
  queue.Receive(message, MakeMavFrame(message, {1, 100, 0}), now_s_);
  queue.Poll(now_s_);
  EXPECT_EQ(queue.TakeResults().size(), 1U);
}

TEST_F(FtpPictures, AbortFailsEverythingAtOnce) {
  Put("a.jpg", Bytes(100000, 'x'));
  FtpPictureQueue queue({}, 0, 3);
  for (std::uint64_t i = 0; i < 4; ++i) queue.Add(Ask(i, "a.jpg", i % 2 == 0));
  bool aborted = false;
  const auto results = Run(&queue, 0, [&] {
    if (now_s_ < 50.1 || aborted) return;
    aborted = true;
    queue.AbortAll("the link is lost", now_s_);
  });
  EXPECT_EQ(results.size(), 4U);
  EXPECT_EQ(std::ranges::count(results, "the link is lost", &FtpPictureQueue::Result::failure), 4);
}

}  // namespace
}  // namespace colmap_ext
