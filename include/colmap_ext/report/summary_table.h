#pragma once

#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"

namespace colmap_ext {

// Column titles and one row an iteration: iteration, photos, registered, covered, mean and RMS
// error, completeness at each distance, seconds a stage, seconds. Columns that no iteration has a
// value for are left out; a single missing value is "-".
struct SummaryCells {
  std::vector<std::string> titles;
  std::vector<std::vector<std::string>> rows;
};
SummaryCells MakeSummaryCells(const SessionSummary& summary);

// Aligned plain text for a terminal (under 100 columns with all of the stages): the results, below
// them the seconds a stage, and a final line that says why the session ended.
std::string SummaryTable(const SessionSummary& summary);

}  // namespace colmap_ext
