// Room that a session takes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "colmap_ext/session/session_options.h"

namespace colmap_ext {

struct DiskNeed {
  std::uint64_t next_bytes = 0;     // of the iteration that comes next
  std::uint64_t session_bytes = 0;  // of all that come until max_iterations or max_photos
};

// An estimate on the safe side, from measured sessions. `photos`: there before the iteration,
// `new_photos`: in it; `iterations_done` ones are on disk. `is_simulation`: photos are written,
// too, and of the simulated camera's size; else their size is taken to be large.
DiskNeed EstimateDiskNeed(const StageOptions& options, bool is_simulation, int photos,
                          int new_photos, int iterations_done);

// One line when `free_bytes` do not do for the next iteration; empty when they do.
std::string DiskComplaint(const DiskNeed& need, std::uint64_t free_bytes,
                          const std::filesystem::path& workspace);
// One line when they will not do for the session.
std::string DiskWarning(const DiskNeed& need, std::uint64_t free_bytes,
                        const std::filesystem::path& workspace);

}  // namespace colmap_ext
