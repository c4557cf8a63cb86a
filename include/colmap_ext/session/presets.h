#pragma once

#include <string>

#include "colmap_ext/session/session_options.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

// Gives the options that depend on the size of the site the values of `preset`, "outdoor"
// (buildings, tens of metres; the defaults) or "indoor" (the paper's room of a few metres), except
// those that the user set. Throws UsageError for another name.
void ApplyPreset(const std::string& preset, const OptionSet& set, StageOptions* options);

}  // namespace colmap_ext
