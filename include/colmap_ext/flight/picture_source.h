// The three ways of a picture from the camera to us: by HTTP, by MAVLink FTP, or through a folder
// into which somebody else puts what the camera took.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/mavlink/frame.h"
#include "colmap_ext/mavlink/ftp_client.h"
#include "colmap_ext/mavlink/messages.h"
#include "colmap_ext/util/http_client.h"

namespace colmap_ext {

// Body of `http://host[:port]/path`. Blocks: for a worker. Throws Error, naming the URL, when the
// server cannot be reached, falls silent, answers anything but 200, or sends fewer bytes than it
// announced. Redirections are not followed: a camera has none.
std::string GetPictureByHttp(const std::string& url, const HttpCallOptions& options);

struct CaptureFolderOptions {
  // Between the report of a picture and the time of its file, s.
  double tolerance_s = 5;
  // Added to a file's time to get ours, s: the clock of a camera that dated the files itself.
  double clock_offset_s = 0;
  // A file that changed less than so long ago may still be written, s.
  double settle_s = 1;
  std::string Check() const;
};

struct CaptureFile {
  std::filesystem::path path;
  double time_s = 0;                   // last change, seconds since 1970
  std::optional<std::int64_t> number;  // last row of digits in the name: 42 in DSC_0042.JPG
};

// One picture that was taken, as the camera reported it.
struct ReportedCapture {
  std::int64_t index = 0;  // of the camera, counted up by one a picture
  double time_s = 0;       // seconds since 1970
};

// Photos below `folder` that have settled, in order of name. A folder that is not there has none: a
// card that is mounted later.
std::vector<CaptureFile> ListCaptureFiles(const std::filesystem::path& folder,
                                          const CaptureFolderOptions& options, double now_unix_s);

// Which file each capture is, as indices into `files`; nothing where no file fits, or where more
// than one does. Cameras number their files from anywhere: the distance between number and index
// that the most captures agree on counts, among pairs whose times fit. Files without numbers are
// told apart by time alone, when the next best is twice as far away. No file is two captures.
std::vector<std::optional<std::size_t>> MatchCaptureFiles(
    const std::vector<ReportedCapture>& captures, const std::vector<CaptureFile>& files,
    const CaptureFolderOptions& options);

// Fetches pictures by MAVLink FTP, one at a time, low resolutions before full ones, in the order of
// asking. Without input, output and clock, as MavFtpClient.
class FtpPictureQueue {
 public:
  struct Request {
    std::uint64_t id = 0;  // comes back with the result
    std::uint8_t system_id = 0;
    std::uint8_t component_id = 0;
    std::string path;
    bool full_resolution = false;
  };
  struct Result {
    std::uint64_t id = 0;
    std::vector<std::uint8_t> bytes;  // whole, when `failure` is empty
    std::string failure;              // one line
  };

  // `first_sequence`: see MavFtpClient. A transfer that fails is tried `attempts` times in all,
  // behind the others of its resolution.
  FtpPictureQueue(const MavFtpClientOptions& options, std::uint16_t first_sequence, int attempts);

  void Add(Request request);
  // Every FILE_TRANSFER_PROTOCOL that is for us, from whomever.
  void Receive(const MavFileTransferProtocol& message, const MavFrame& from, double now_s);
  // What to send now; begins the next transfer when there is none. Call after Add and Receive, and
  // when NextTimeS() has come.
  std::vector<MavFileTransferProtocol> Poll(double now_s);
  std::optional<double> NextTimeS() const { return client_.NextTimeS(); }
  std::vector<Result> TakeResults();
  // The vehicle is gone: everything that waits or runs fails now with `reason`.
  void AbortAll(const std::string& reason, double now_s);
  std::size_t Waiting() const { return low_.size() + full_.size() + (active_ ? 1 : 0); }

 private:
  struct Job {
    Request request;
    int attempts = 0;
  };
  void FinishActive();
  void BeginNext(double now_s);

  MavFtpClient client_;
  int attempts_;
  std::deque<Job> low_;
  std::deque<Job> full_;
  std::optional<Job> active_;
  Request last_;  // whom the client speaks to, its farewell included
  std::vector<Result> results_;
};

}  // namespace colmap_ext
