#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/endpoint.h"
#include "colmap_ext/mavlink/ftp_client.h"
#include "colmap_ext/mavlink/ftp_server.h"
#include "colmap_ext/mavlink/link.h"
#include "colmap_ext/util/error.h"
#include "fuzz/targets.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

template <typename... Messages>
void UnpackAsEverything(const MavFrame& frame, MavMessageList<Messages...>) {
  int unpacked = 0;
  ((unpacked += UnpackMav<Messages>(frame).has_value() ? 1 : 0), ...);
  Promise(unpacked == 1, "a packet that was given out is of one message that we know");
}

// A folder that is served, and beside it what must never be seen. One for a process; the operating
// system clears it away.
struct ServedFolder {
  ServedFolder() : root(fs::temp_directory_path() / ("fuzz_ftp_" + std::to_string(getpid()))) {
    fs::create_directories(root / "served" / "low");
    std::ofstream(root / "secret") << secret;
    std::ofstream(root / "served" / "a") << std::string(1000, 'a');
    std::ofstream(root / "served" / "low" / "b") << "b";
    if (!fs::exists(root / "served" / "up")) fs::create_symlink("..", root / "served" / "up");
  }
  ~ServedFolder() { fs::remove_all(root); }
  ServedFolder(const ServedFolder&) = delete;
  ServedFolder& operator=(const ServedFolder&) = delete;
  fs::path root;
  std::string secret = "SECRETSECRET";
};

// std::ranges::search does not compile with clang 14 and libstdc++ 12.
template <typename Whole, typename Part>
bool Contains(const Whole& whole, const Part& part) {
  return std::search(whole.begin(), whole.end(), part.begin(), part.end()) != whole.end();
}

// The bytes as pieces: one byte of length, then so many bytes.
std::vector<std::span<const std::uint8_t>> PiecesOf(std::span<const std::uint8_t> bytes) {
  std::vector<std::span<const std::uint8_t>> pieces;
  while (bytes.size() > 1) {
    const std::size_t length = std::min<std::size_t>(bytes[0], bytes.size() - 1);
    pieces.push_back(bytes.subspan(1, length));
    bytes = bytes.subspan(1 + length);
  }
  return pieces;
}

MavFileTransferProtocol FtpMessage(std::span<const std::uint8_t> piece) {
  MavFileTransferProtocol message;
  std::copy_n(piece.begin(), std::min(piece.size(), message.payload.size()),
              message.payload.begin());
  return message;
}

}  // namespace

void FuzzMavParser(std::span<const std::uint8_t> bytes) {
  MavParser parser;
  MavLinkStatistics statistics;
  MavSigning signing({}, {}, {}, nullptr);
  std::uint64_t given_out = 0;
  const auto receive = [&](const MavFrame& frame) {
    ++given_out;
    const MavMessageInfo* const info = FindMavMessage(frame.message_id);
    Promise(info != nullptr && MavChecksumOf(frame, info->crc_extra) == frame.checksum,
            "a packet that was given out has the right checksum");
    const std::vector<std::uint8_t> packet = MavFrameBytes(frame);
    Promise(Contains(bytes, packet), "a packet that was given out came in");
    UnpackAsEverything(frame, MavMessages{});
    statistics.Received(frame, static_cast<double>(given_out));
    signing.Check(frame, 1.8e9);
  };
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t count = std::min<std::size_t>(1 + bytes[at] % 64, bytes.size() - at);
    parser.Feed(bytes.subspan(at, count), receive);
    at += count;
  }
  parser.EndOfDatagram(receive);
  Promise(parser.Counts().frames == given_out, "packets are counted");
  std::size_t heartbeats = 0;
  parser.Feed(PackMav(MavHeartbeat{}, {1, 1, 0}), [&](const MavFrame&) { ++heartbeats; });
  Promise(heartbeats == 1, "whatever came before, the next packet is found");
}

void FuzzMavFtpServer(std::span<const std::uint8_t> bytes) {
  static const ServedFolder folder;
  MavFtpServerOptions options;
  options.burst_packets = 20;
  MavFtpServer server(folder.root / "served", options);
  double now_s = 0;
  for (const auto piece : PiecesOf(bytes)) {
    MavFrame from;
    from.component_id = piece.empty() ? 0 : piece[0] & 1U;
    std::vector<MavFileTransferProtocol> answers = server.Receive(FtpMessage(piece), from, now_s);
    now_s += 0.01;
    std::ranges::copy(server.Poll(now_s), std::back_inserter(answers));
    Promise(server.OpenSessions() <= 4, "there are no more sessions than allowed");
    for (const MavFileTransferProtocol& answer : answers) {
      Promise(!Contains(answer.payload, folder.secret), "nothing outside the folder is served");
      Promise(DecodeMavFtp(answer).has_value(), "answers are well-formed");
    }
  }
}

void FuzzMavFtpClient(std::span<const std::uint8_t> bytes) {
  MavFtpClientOptions options;
  options.max_file_bytes = 100000;
  MavFtpClient client(options);
  double now_s = 0;
  bool list_next = false;
  std::size_t asked = 0;
  MavFtpPayload request;
  for (const auto piece : PiecesOf(bytes)) {
    if (client.Status() != MavFtpStatus::kRunning) {
      list_next ? client.List("a", now_s) : client.Download("a", now_s);
      list_next = !list_next;
    }
    for (const MavFtpPayload& payload : client.TakeOutgoing()) {
      request = payload;
      ++asked;
    }
    auto answer = DecodeMavFtp(FtpMessage(piece));
    if (answer) {
      // Nobody guesses numbers: an answer to the last request, mostly.
      answer->sequence = static_cast<std::uint16_t>(request.sequence + 1 + answer->sequence % 3);
      if (answer->session < 0xF0) answer->request_opcode = request.opcode;
      answer->session &= 1U;
      client.Receive(*answer, now_s);
    }
    Promise(client.Data().size() <= options.max_file_bytes, "files have at most the allowed size");
    Promise(client.BytesMissing() <= client.Data().size(), "no more is missing than there is");
    Promise(client.Status() != MavFtpStatus::kDone || client.BytesMissing() == 0,
            "what is done is whole");
    now_s += 0.02;
    client.Poll(now_s);
  }
  // A server that falls silent cannot keep the client.
  for (int i = 0; i < 5000 && client.Status() == MavFtpStatus::kRunning; ++i) {
    now_s += 0.02;
    client.Poll(now_s);
  }
  Promise(client.Status() != MavFtpStatus::kRunning, "silence ends a transfer");
}

void FuzzMavUrls(std::span<const std::uint8_t> bytes) {
  const std::string text(bytes.begin(), bytes.end());
  if (const auto url = ParseMavFtpUrl(text)) Promise(!url->path.empty(), "a file has a path");
  try {
    const MavLinkUrl url = ParseMavLinkUrl(text);
    Promise(ParseMavLinkUrl(MavLinkUrlText(url)) == url, "a link's address comes back as text");
  } catch (const UsageError&) {
    // What is no address is refused in this way.
  }
}

}  // namespace colmap_ext
