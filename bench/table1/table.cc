#include "table.h"

#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

constexpr double kInchM = 0.0254;

}  // namespace

PlanRow RowOf(const std::string& plan, const std::string& terms, int photos, int registered,
              double metres, const EvaluationResult& result) {
  return {plan,
          terms,
          static_cast<double>(photos),
          static_cast<double>(registered),
          metres,
          result.errors.mean_m,
          result.errors.completeness.at(0),
          result.errors.completeness.at(1),
          result.seen ? result.seen->mean_m : 0};
}

PlanRow MeanOf(const std::vector<PlanRow>& rows) {
  PlanRow mean = rows.front();
  const auto number = static_cast<double>(rows.size());
  for (double PlanRow::*column :
       {&PlanRow::photos, &PlanRow::registered, &PlanRow::metres, &PlanRow::mean_error_m,
        &PlanRow::within_1_inch, &PlanRow::within_2_inch, &PlanRow::seen_mean_error_m}) {
    double sum = 0;
    for (const PlanRow& row : rows) sum += row.*column;
    mean.*column = sum / number;
  }
  return mean;
}

std::string TableOf(const std::string& title, const std::vector<PlanRow>& rows) {
  std::string text =
      "### " + title +
      "\n\n| plan | | photos | registered | metres | mean error, inch | within 1 inch "
      "| within 2 inch | mean error where two photos see, inch |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const PlanRow& row : rows) {
    text += "| " + row.plan + " | " + row.terms;
    for (const double value : {row.photos, row.registered, row.metres}) {
      text += " | " + FormatNumber("%.0f", value);
    }
    text += " | " + FormatNumber("%.2f", row.mean_error_m / kInchM);
    text += " | " + FormatNumber("%.1f %%", 100 * row.within_1_inch);
    text += " | " + FormatNumber("%.1f %%", 100 * row.within_2_inch);
    text += " | " + FormatNumber("%.2f", row.seen_mean_error_m / kInchM) + " |\n";
  }
  return text + "\n";
}

}  // namespace colmap_ext
