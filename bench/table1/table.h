// Rows of Table 1 and their Markdown.
#pragma once

#include <string>
#include <vector>

#include "colmap_ext/eval/evaluate.h"

namespace colmap_ext {

struct PlanRow {
  std::string plan;
  std::string terms;  // "as the paper", "equal photos", "equal metres"
  double photos = 0;
  double registered = 0;
  double metres = 0;
  double mean_error_m = 0;   // over all of the truth, as the paper
  double within_1_inch = 0;  // shares, 0 … 1
  double within_2_inch = 0;
  double seen_mean_error_m = 0;  // over what two photos see
};

PlanRow RowOf(const std::string& plan, const std::string& terms, int photos, int registered,
              double metres, const EvaluationResult& result);

// The mean of rows of the same plan on other seeds; plan and terms of the first. Not empty.
PlanRow MeanOf(const std::vector<PlanRow>& rows);

// With the paper's units: inches and %.
std::string TableOf(const std::string& title, const std::vector<PlanRow>& rows);

}  // namespace colmap_ext
