// What every benchmark program does the same way at its begin and its end.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/util/options.h"
#include "support/bench_report.h"

namespace colmap_ext {

// Reads the command line. False when it asks for the help, which is then printed.
bool ReadCommandLine(const std::vector<std::string>& arguments, OptionSet* set);

// Prints the whole table and writes <results>/<name>.json.
void PrintAndWrite(const BenchReport& report, const std::filesystem::path& results);

// main(): runs `run` with the arguments and turns errors into a line and an exit code.
int BenchMain(const std::string& name, int argc, char** argv,
              const std::function<int(const std::vector<std::string>&)>& run);

}  // namespace colmap_ext
