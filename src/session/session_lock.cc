#include "colmap_ext/session/session_lock.h"

#include <unistd.h>

#include <fstream>
#include <string>

namespace colmap_ext {
namespace {

std::filesystem::path PathIn(const Workspace& workspace) {
  return workspace.root() / ".session.lock";
}

int ReadHolder(const std::filesystem::path& path) {
  int process = 0;
  std::ifstream(path) >> process;
  return process;
}

std::string BusyMessage(const Workspace& workspace) {
  const int process = ReadHolder(PathIn(workspace));
  return workspace.root().string() + ": a session is running in this workspace" +
         (process > 0 ? " (process " + std::to_string(process) + ")" : "") +
         "; wait until it has ended, or choose another --workspace_path";
}

}  // namespace

SessionLock::SessionLock(const Workspace& workspace)
    : lock_(PathIn(workspace), BusyMessage(workspace)) {
  // For people and for HolderOf; the lock itself is on the open file, whatever is in it.
  std::ofstream(PathIn(workspace)) << getpid() << '\n';
}

std::optional<int> SessionLock::HolderOf(const Workspace& workspace) {
  if (!FileLock::IsHeld(PathIn(workspace))) return std::nullopt;
  return ReadHolder(PathIn(workspace));
}

}  // namespace colmap_ext
