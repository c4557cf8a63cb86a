// libFuzzer's entry for the target that the build names.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "fuzz/targets.h"

// The name and the signature are libFuzzer's.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto targets = colmap_ext::AllFuzzTargets();
  static const auto target =
      std::ranges::find(targets, COLMAP_EXT_FUZZ_TARGET, &colmap_ext::FuzzTarget::name);
  target->run({data, size});  // what it throws ends the program, with the input kept
  return 0;
}
