#include "bench_main.h"

#include <iostream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {

int BenchMain(const std::string& name,
              const std::function<int(const std::vector<std::string>& arguments)>& run, int argc,
              char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const UsageError& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return 1;
  }
}

}  // namespace colmap_ext
