#include "session_curves.h"

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

std::string Cell(const std::optional<double>& value, const char* format, double factor) {
  return " | " + (value ? FormatNumber(format, factor * *value) : std::string("–"));
}

}  // namespace

std::string CurveRow(const std::string& label, const IterationSummary& iteration) {
  std::string text = "| " + label + " | " + std::to_string(iteration.photos) + " | " +
                     std::to_string(iteration.registered);
  text += Cell(iteration.covered_ratio, "%.1f %%", 100);
  text += Cell(iteration.mean_error_m, "%.1f", 1000);
  text += Cell(iteration.rms_error_m, "%.1f", 1000);
  for (const CompletenessValue& value : iteration.completeness) {
    text += Cell(value.share, "%.1f %%", 100);
  }
  return text + " |\n";
}

std::string CurveHeader(const std::string& label, const IterationSummary& iteration) {
  std::string text =
      "| " + label + " | photos | registered | covered | mean error, mm | RMS error, mm";
  std::string rule = "|---|---|---|---|---|---";
  for (const CompletenessValue& value : iteration.completeness) {
    text += " | within " + value.key;
    rule += "|---";
  }
  return text + " |\n" + rule + "|\n";
}

std::string CurveTable(const std::string& title, const SessionSummary& summary) {
  if (summary.iterations.empty()) throw Error(title + ": the session has no iteration");
  std::string text = "### " + title + ": the fast model after every iteration\n\n" +
                     CurveHeader("iteration", summary.iterations.front());
  for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
    text += CurveRow(std::to_string(i), summary.iterations[i]);
  }
  return text + "\n";
}

}  // namespace colmap_ext
