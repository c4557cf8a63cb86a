// What every benchmark's main() does.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace colmap_ext {

// Calls `run` with the arguments after the program's name and returns its exit code. What it throws
// is printed as "<name>: …"; exit code 2 for a UsageError, else 1.
int BenchMain(const std::string& name,
              const std::function<int(const std::vector<std::string>& arguments)>& run, int argc,
              char** argv);

}  // namespace colmap_ext
