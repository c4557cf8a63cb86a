#include "flight/picture_fetch.h"

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

void Replace(const std::string& mark, const std::string& value, std::string* text) {
  for (std::size_t at = text->find(mark); at != std::string::npos; at = text->find(mark, at)) {
    text->replace(at, mark.size(), value);
    at += value.size();
  }
}

// Seconds since 1970 of "2026-11-22T08:00:00.5Z". Throws Error for a report without a time.
double UnixTimeOf(const FetchRequest& request) {
  std::tm utc{};
  const char* rest = strptime(request.capture.record.time.c_str(), "%Y-%m-%dT%H:%M:%S", &utc);
  if (rest == nullptr) {
    throw Error(request.photo + ": its report has no time, by which to know its file");
  }
  return static_cast<double>(timegm(&utc)) + (*rest == '.' ? std::strtod(rest, nullptr) : 0);
}

// The file that somebody else put there, told by time and number.
std::string FetchFromFolder(const FetchRequest& request, const std::filesystem::path& folder) {
  const CaptureFolderOptions options;
  const double now_s = static_cast<double>(std::time(nullptr));
  const std::vector<CaptureFile> files = ListCaptureFiles(folder, options, now_s);
  const auto matches =
      MatchCaptureFiles({{request.capture.record.index, UnixTimeOf(request)}}, files, options);
  if (!matches.at(0)) {
    throw Error(request.photo + ": no file in " + folder.string() + " is certainly it");
  }
  return ReadFile(files.at(*matches[0]).path);
}

}  // namespace

std::string PictureUrl(const FetchRequest& request, const std::string& pattern) {
  if (pattern.empty()) return request.full_resolution ? "" : request.capture.file_url;
  std::string url = pattern;
  char digits[16];
  std::snprintf(digits, sizeof digits, "%05d", request.capture.record.index);
  Replace("{index5}", digits, &url);
  Replace("{index}", std::to_string(request.capture.record.index), &url);
  Replace("{resolution}", request.full_resolution ? "full" : "low", &url);
  return url;
}

std::string FetchPicture(const FetchRequest& request, const PictureSourceOptions& options) {
  if (!options.folder.empty()) return FetchFromFolder(request, options.folder);
  const std::string url = PictureUrl(request, options.url);
  if (url.empty()) {
    throw Error(request.photo +
                ": nobody says where the camera keeps it; give --picture_url or --capture_folder");
  }
  return GetPictureByHttp(url, HttpCallOptions());
}

}  // namespace colmap_ext
