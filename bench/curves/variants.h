// The sessions that are compared: each differs from the usual one in one thing.
#pragma once

#include <string>
#include <vector>

namespace colmap_ext {

struct Variant {
  std::string name;
  std::string what;                    // a few words for the table
  std::vector<std::string> arguments;  // of active_capture, beside those of every session
};

// The usual session comes first, as "submodular"; then the other planners, the ablations of the
// fast stereo and of the coverage rule, GPS noise and photo widths.
const std::vector<Variant>& AllVariants();

// The variants of a list with commas, in its order. "planners", "stereo", "coverage", "gps" and
// "width" stand for the usual session and those of that kind, "all" for all. Throws UsageError that
// names what there is.
std::vector<Variant> VariantsOf(const std::string& list);

}  // namespace colmap_ext
