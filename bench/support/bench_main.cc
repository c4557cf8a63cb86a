#include "support/bench_main.h"

#include <iostream>

#include "colmap_ext/util/exit_code.h"

namespace colmap_ext {

bool ReadCommandLine(const std::vector<std::string>& arguments, OptionSet* set) {
  set->Parse(arguments);
  if (set->HelpRequested()) std::cout << set->HelpText();
  return !set->HelpRequested();
}

void PrintAndWrite(const BenchReport& report, const std::filesystem::path& results) {
  std::cout << report.ToMarkdown();
  report.Write(results);
}

int BenchMain(const std::string& name, int argc, char** argv,
              const std::function<int(const std::vector<std::string>&)>& run) {
  return ExitCodeOf(name, [&] { return run({argv + 1, argv + argc}); });
}

}  // namespace colmap_ext
