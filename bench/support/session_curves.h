// What every iteration of a session gained.
#pragma once

#include <string>

#include "colmap_ext/report/summary.h"

namespace colmap_ext {

// One row of a Markdown table: `label`, photos, registered ones, coverage, and mean error, RMS
// error and completeness of the fast model. Errors are "–" where the session had no truth.
std::string CurveRow(const std::string& label, const IterationSummary& iteration);

// The two lines above such rows; the distances of completeness are those of `iteration`.
std::string CurveHeader(const std::string& label, const IterationSummary& iteration);

// A table with a row an iteration. Throws Error for a session without any.
std::string CurveTable(const std::string& title, const SessionSummary& summary);

}  // namespace colmap_ext
