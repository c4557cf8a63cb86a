// What is fuzzed. The same targets run under libFuzzer (option COLMAP_EXT_FUZZ) and, with the kept
// corpus and random mutations of it, in every test run (replay_test.cc).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace colmap_ext {

struct FuzzTarget {
  std::string name;  // of its folder in corpus/ and of its program, fuzz_<name>
  // Takes any bytes. Throws std::logic_error when a promise is broken, and nothing else.
  std::function<void(std::span<const std::uint8_t>)> run;
};

std::vector<FuzzTarget> AllFuzzTargets();

// Throws std::logic_error.
void Promise(bool holds, const char* what);

// mavlink_targets.cc
void FuzzMavParser(std::span<const std::uint8_t> bytes);
void FuzzMavFtpServer(std::span<const std::uint8_t> bytes);
void FuzzMavFtpClient(std::span<const std::uint8_t> bytes);
void FuzzMavUrls(std::span<const std::uint8_t> bytes);

}  // namespace colmap_ext
