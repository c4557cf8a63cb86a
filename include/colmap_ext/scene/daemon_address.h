// How the programs of a workspace find its flight daemon (docs/flight_api.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace colmap_ext {

// What flightd.json of the workspace says.
struct DaemonAddress {
  int port = 0;  // on 127.0.0.1
  int pid = 0;
  std::string token;  // needed by every request; the file is readable for its owner only
};
std::filesystem::path DaemonAddressPath(const std::filesystem::path& workspace_path);
// A daemon holds this lock (util/file_lock.h) as long as it lives.
std::filesystem::path DaemonLockPath(const std::filesystem::path& workspace_path);
// nullopt: there is no file, or the daemon that wrote it is gone. Throws Error for a damaged file.
std::optional<DaemonAddress> FindDaemon(const std::filesystem::path& workspace_path);
void WriteDaemonAddress(const DaemonAddress& address, const std::filesystem::path& workspace_path);

}  // namespace colmap_ext
