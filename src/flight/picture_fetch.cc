#include "flight/picture_fetch.h"

#include <cstdio>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

void Replace(const std::string& mark, const std::string& value, std::string* text) {
  for (std::size_t at = text->find(mark); at != std::string::npos; at = text->find(mark, at)) {
    text->replace(at, mark.size(), value);
    at += value.size();
  }
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
  const std::string url = PictureUrl(request, options.url);
  if (url.empty()) {
    throw Error(request.photo +
                ": nobody says where the camera keeps it; give --picture_url or --capture_folder");
  }
  return GetPictureByHttp(url, HttpPictureOptions());
}

}  // namespace colmap_ext
