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
  int mutations = 100000;  // of the corpus in every test run
};

std::vector<FuzzTarget> AllFuzzTargets();

// Throws std::logic_error.
void Promise(bool holds, const char* what);

// mavlink_targets.cc
void FuzzMavParser(std::span<const std::uint8_t> bytes);
void FuzzMavFtpServer(std::span<const std::uint8_t> bytes);
void FuzzMavFtpClient(std::span<const std::uint8_t> bytes);
void FuzzMavUrls(std::span<const std::uint8_t> bytes);
// file_targets.cc
void FuzzColmapBinary(std::span<const std::uint8_t> bytes);
void FuzzColmapText(std::span<const std::uint8_t> bytes);
void FuzzDenseMap(std::span<const std::uint8_t> bytes);
void FuzzStereoMemory(std::span<const std::uint8_t> bytes);
void FuzzPly(std::span<const std::uint8_t> bytes);
void FuzzObj(std::span<const std::uint8_t> bytes);
void FuzzLas(std::span<const std::uint8_t> bytes);
void FuzzExif(std::span<const std::uint8_t> bytes);
void FuzzGeoJson(std::span<const std::uint8_t> bytes);
void FuzzPositions(std::span<const std::uint8_t> bytes);
void FuzzIni(std::span<const std::uint8_t> bytes);
void FuzzWorkspaceJson(std::span<const std::uint8_t> bytes);
void FuzzCaptureJournal(std::span<const std::uint8_t> bytes);
// request_targets.cc
void FuzzDaemonApi(std::span<const std::uint8_t> bytes);
void FuzzFlightJournal(std::span<const std::uint8_t> bytes);
void FuzzPageRequests(std::span<const std::uint8_t> bytes);

}  // namespace colmap_ext
