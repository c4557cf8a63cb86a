// Gets one picture's bytes from where the camera keeps it. Blocks: for workers.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/flight/mission_machine.h"

namespace colmap_ext {

struct PictureSourceOptions {
  std::string url;               // with {index}, {index5}, {resolution}; empty: the report's own
  std::filesystem::path folder;  // watched instead when not empty
};

// Throws Error with the reason: no place known, no answer within 30 s, not found.
std::string FetchPicture(const FetchRequest& request, const PictureSourceOptions& options);

// The URL of a picture; empty when nobody says where it is.
std::string PictureUrl(const FetchRequest& request, const std::string& pattern);

}  // namespace colmap_ext
