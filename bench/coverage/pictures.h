// Where the map is right and where it is wrong.
#pragma once

#include <filesystem>
#include <vector>

#include "judged.h"

namespace colmap_ext {

// The fast surface from two sides, coloured by its nearest judged point: green where it is called
// covered and is good, red where it is called uncovered and is bad, yellow for a false alarm, blue
// where something bad was missed; grey is not judged. Writes <stem>_30.png and <stem>_210.png.
void PaintVerdicts(const JudgedFlight& judged, const std::filesystem::path& surface, double bad_m,
                   const std::filesystem::path& stem);

// The paper's comparison of coverage maps: side by side our score, the rule of density and
// smoothness for laser scanners, and the truth. As many points as are bad are orange in all three,
// those that each rule doubts most; blue is the rest, grey is not judged. Writes
// <stem>_rules_30.png and <stem>_rules_210.png.
void PaintComparison(const JudgedFlight& judged, const std::filesystem::path& surface, double bad_m,
                     const std::filesystem::path& stem);

}  // namespace colmap_ext
