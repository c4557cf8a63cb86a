#include "colmap_ext/scene/daemon_address.h"

#include <signal.h>

#include <fstream>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/file_lock.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

std::filesystem::path DaemonAddressPath(const std::filesystem::path& workspace_path) {
  return workspace_path / "flightd.json";
}

std::filesystem::path DaemonLockPath(const std::filesystem::path& workspace_path) {
  return workspace_path / ".flightd.lock";
}

std::optional<DaemonAddress> FindDaemon(const std::filesystem::path& workspace_path) {
  const std::filesystem::path path = DaemonAddressPath(workspace_path);
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  const DaemonAddress address{root["port"].Integer(), root["pid"].Integer(), root["token"].Text()};
  // A killed daemon leaves its lock's file, and its number to somebody else.
  const std::filesystem::path lock = DaemonLockPath(workspace_path);
  const bool is_alive = std::filesystem::exists(lock)
                            ? FileLock::IsHeld(lock)
                            : address.pid > 0 && kill(address.pid, 0) == 0;
  return is_alive ? std::optional(address) : std::nullopt;
}

void WriteDaemonAddress(const DaemonAddress& address, const std::filesystem::path& workspace_path) {
  const std::filesystem::path path = DaemonAddressPath(workspace_path);
  const std::filesystem::path temporary = TemporaryPathFor(path);
  WriteFileAtomically(temporary, "");
  std::filesystem::permissions(
      temporary, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  std::ofstream stream(temporary);
  stream << Json({{"port", address.port}, {"pid", address.pid}, {"token", address.token}}).dump()
         << '\n';
  stream.close();
  if (!stream) throw Error(path.string() + ": cannot be written");
  CommitTemporaryFile(temporary, path);
}

}  // namespace colmap_ext
