// One session in one workspace.
#pragma once

#include <filesystem>
#include <optional>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/file_lock.h"

namespace colmap_ext {

// Held by a program while it works on the session of a workspace, by .session.lock in it. The
// system releases the lock of a killed program.
class SessionLock {
 public:
  // Throws Error at once, naming the other process, when a session is at work there.
  explicit SessionLock(const Workspace& workspace);

  // The process that works on this session now; nullopt: none does. 0: not known.
  static std::optional<int> HolderOf(const Workspace& workspace);

 private:
  FileLock lock_;
};

}  // namespace colmap_ext
