#include "session_curves.h"

#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

std::string Cell(const std::optional<double>& value, const char* format, double factor) {
  return " | " + (value ? FormatNumber(format, factor * *value) : std::string("–"));
}

}  // namespace

std::string CurveTable(const std::string& title, const SessionSummary& summary) {
  std::string text = "### " + title +
                     ": the fast model after every iteration\n\n"
                     "| iteration | photos | registered | covered | mean error, mm | RMS error, mm";
  std::string rule = "\n|---|---|---|---|---|---";
  if (!summary.iterations.empty()) {
    for (const CompletenessValue& value : summary.iterations.front().completeness) {
      text += " | within " + value.key;
      rule += "|---";
    }
  }
  text += " |" + rule + "|\n";
  for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
    const IterationSummary& iteration = summary.iterations[i];
    text += "| " + std::to_string(i) + " | " + std::to_string(iteration.photos) + " | " +
            std::to_string(iteration.registered);
    text += Cell(iteration.covered_ratio, "%.1f %%", 100);
    text += Cell(iteration.mean_error_m, "%.1f", 1000);
    text += Cell(iteration.rms_error_m, "%.1f", 1000);
    for (const CompletenessValue& value : iteration.completeness) {
      text += Cell(value.share, "%.1f %%", 100);
    }
    text += " |\n";
  }
  return text + "\n";
}

}  // namespace colmap_ext
