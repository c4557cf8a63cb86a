#include "update_lock.h"

namespace colmap_ext {

std::filesystem::path UpdateLock::PathFor(const std::filesystem::path& database_path) {
  return database_path.parent_path() / ("." + database_path.filename().string() + ".lock");
}

UpdateLock::UpdateLock(const std::filesystem::path& database_path)
    : lock_(PathFor(database_path),
            database_path.string() +
                ": another update of this database is running; wait until it has ended") {}

}  // namespace colmap_ext
