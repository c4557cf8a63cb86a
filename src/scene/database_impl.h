#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "colmap_ext/scene/database.h"
#include "scene/database_schema.h"
#include "scene/sqlite.h"

namespace colmap_ext {

struct Database::Impl {
  Impl(const std::filesystem::path& path, SqliteConnection::Mode mode)
      : connection(path, mode), schema(DetectSchema(connection)) {}

  SqliteConnection connection;
  DatabaseSchema schema;
};

// What the tables of rigs and frames hold, not yet checked.
FrameTable ReadFrameTableRows(const SqliteConnection& connection);

// "images 3 and 7", for messages.
inline std::string NameOfPair(const ImagePair& pair) {
  return "images " + std::to_string(pair.first) + " and " + std::to_string(pair.second);
}

// The database's own order of a pair is smaller id first.
inline bool IsSwapped(const ImagePair& pair) { return pair.first > pair.second; }
void SwapMatches(std::vector<KeypointMatch>* matches);
// The same geometry seen from the other photo. Throws Error for a homography without inverse.
void InvertGeometry(TwoViewGeometry* geometry);

}  // namespace colmap_ext
