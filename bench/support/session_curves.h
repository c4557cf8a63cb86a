// What every iteration of a session gained.
#pragma once

#include <string>

#include "colmap_ext/report/summary.h"

namespace colmap_ext {

// A Markdown table: a row an iteration, with photos, registered ones, coverage, and mean error and
// completeness of the fast model. Errors are "–" where the session had no truth.
std::string CurveTable(const std::string& title, const SessionSummary& summary);

}  // namespace colmap_ext
