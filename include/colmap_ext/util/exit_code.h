// The exit codes of our programs: 0 done, 1 failed, 2 wrong usage.
#pragma once

#include <functional>
#include <string>

namespace colmap_ext {

// `kind`: "usage", "stopped" (by the user), "memory" or "failed".
using FailureReport = std::function<void(const char* kind, const std::string& what)>;

// What main() returns: `run`'s exit code or, after one call of `report`, 2 for a UsageError and 1
// for every other exception.
int ExitCodeOf(const std::function<int()>& run, const FailureReport& report);
// Reports one line "<program>: <what>" on standard error.
int ExitCodeOf(const std::string& program, const std::function<int()>& run);

}  // namespace colmap_ext
