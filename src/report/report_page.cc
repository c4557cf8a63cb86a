#include "colmap_ext/report/report_page.h"

#include <algorithm>
#include <cstdio>
#include <system_error>

#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"
#include "report/html_text.h"
#include "report/line_chart.h"
#include "report/page_assets.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

std::string Duration(double seconds) {
  if (seconds < 120) return FormatNumber("%.0f s", seconds);
  return FormatNumber("%.1f min", seconds / 60);
}

std::string Tile(const std::string& value, const std::string& label) {
  return "<div class=\"tile\"><b>" + EscapeHtml(value) + "</b><span>" + EscapeHtml(label) +
         "</span></div>\n";
}

// What the last iteration says, at a glance.
std::string Tiles(const SessionSummary& summary) {
  if (summary.iterations.empty()) return "";
  const IterationSummary& last = summary.iterations.back();
  std::string html = "<div class=\"tiles\">\n";
  html += Tile(std::to_string(summary.iterations.size()), "iterations");
  html += Tile(std::to_string(last.registered) + " / " + std::to_string(last.photos),
               "photos registered");
  if (last.covered_ratio)
    html += Tile(FormatNumber("%.1f %%", 100 * *last.covered_ratio), "covered");
  if (last.reachable_covered_ratio) {
    html += Tile(FormatNumber("%.1f %%", 100 * *last.reachable_covered_ratio),
                 "of the reachable covered");
  }
  if (last.mean_error_m)
    html += Tile(FormatNumber("%.1f mm", 1000 * *last.mean_error_m), "mean error");
  if (last.rms_error_m)
    html += Tile(FormatNumber("%.1f mm", 1000 * *last.rms_error_m), "RMS error");
  for (const CompletenessValue& value : last.completeness) {
    html += Tile(FormatNumber("%.1f %%", 100 * value.share), "complete within " + value.key);
  }
  double seconds = 0;
  for (const IterationSummary& iteration : summary.iterations) seconds += iteration.wall_s;
  return html + Tile(Duration(seconds), "in all") + "</div>\n";
}

template <typename Get>
ChartSeries Series(const SessionSummary& summary, const std::string& label,
                   const std::string& css_class, const Get& get) {
  ChartSeries series{label, css_class, {}};
  for (const IterationSummary& iteration : summary.iterations) {
    series.values.push_back(get(iteration));
  }
  return series;
}

std::optional<double> Scaled(const std::optional<double>& value, double factor) {
  return value ? std::optional<double>(*value * factor) : std::nullopt;
}

std::string Charts(const SessionSummary& summary) {
  using Row = const IterationSummary&;
  const std::vector<LineChart> charts = {
      {"Covered, % by iteration",
       " %",
       {Series(summary, "covered", "series-1",
               [](Row row) { return Scaled(row.covered_ratio, 100); }),
        Series(summary, "reachable", "series-2",
               [](Row row) { return Scaled(row.reachable_covered_ratio, 100); })},
       0,
       100},
      {"Error against the truth, mm by iteration",
       " mm",
       {Series(summary, "mean", "series-1", [](Row row) { return Scaled(row.mean_error_m, 1000); }),
        Series(summary, "RMS", "series-2", [](Row row) { return Scaled(row.rms_error_m, 1000); })},
       0,
       std::nullopt},
      {"Photos by iteration",
       "",
       {Series(summary, "taken", "series-2",
               [](Row row) { return std::optional<double>(row.photos); }),
        Series(summary, "registered", "series-1",
               [](Row row) { return std::optional<double>(row.registered); })},
       0,
       std::nullopt}};
  std::string html;
  for (const LineChart& chart : charts) {
    const std::string svg = LineChartSvg(chart);
    if (!svg.empty()) html += "<div><h3>" + EscapeHtml(chart.title) + "</h3>\n" + svg + "</div>\n";
  }
  if (html.empty()) return "";
  return "<section><h2>Progress</h2>\n<div class=\"charts\">\n" + html + "</div></section>\n";
}

std::string Table(const SessionSummary& summary) {
  const SummaryCells cells = MakeSummaryCells(summary);
  std::string html = "<section><h2>Iterations</h2>\n<div class=\"scroll\"><table><thead><tr>";
  for (const std::string& title : cells.titles) html += "<th>" + EscapeHtml(title) + "</th>";
  html += "</tr></thead><tbody>\n";
  for (const auto& row : cells.rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + EscapeHtml(cell) + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></section>\n";
}

std::string Navigation(std::size_t count) {
  if (count < 2) return "";
  std::string html =
      "<nav aria-label=\"Iterations\"><button data-show=\"all\" aria-pressed=\"true\">All "
      "iterations</button>";
  for (std::size_t i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    html += "<button data-show=\"" + number + "\" aria-pressed=\"false\">" + number + "</button>";
  }
  return html + "</nav>\n";
}

std::string Figure(const ReportPicture& picture, const std::string& link) {
  const std::string title = EscapeHtml(picture.title);
  const std::string kind = EscapeHtml(picture.file.stem().string());
  return "<figure data-kind=\"" + kind +
         "\"><button type=\"button\" aria-label=\"Enlarge: " + title +
         "\"><img loading=\"lazy\" src=\"" + EscapeHtml(EncodeUrlPath(link)) + "\" alt=\"" + title +
         "\"></button><figcaption>" + title + "</figcaption></figure>\n";
}

std::string Unregistered(const IterationSummary& iteration) {
  if (iteration.unregistered.empty()) return "";
  std::string html = "<details><summary>" + std::to_string(iteration.unregistered.size()) +
                     " photos without a pose</summary><ul class=\"names\">\n";
  for (const std::string& name : iteration.unregistered)
    html += "<li>" + EscapeHtml(name) + "</li>";
  return html + "</ul></details>\n";
}

std::string IterationSection(std::size_t index, const IterationSummary& iteration,
                             const std::vector<ReportPicture>& pictures,
                             const std::vector<std::string>& links) {
  const std::string number = std::to_string(index);
  std::string facts = std::to_string(iteration.registered) + " of " +
                      std::to_string(iteration.photos) + " photos registered";
  if (iteration.covered_ratio)
    facts += FormatNumber(", %.1f %% covered", 100 * *iteration.covered_ratio);
  if (iteration.mean_error_m)
    facts += FormatNumber(", mean error %.1f mm", 1000 * *iteration.mean_error_m);
  facts += ", " + Duration(iteration.wall_s);
  std::string html = "<section data-iteration=\"" + number +
                     "\"><div class=\"head\"><h2>Iteration " + number + "</h2><p class=\"soft\">" +
                     EscapeHtml(facts) + "</p></div>\n";
  if (!pictures.empty()) {
    html += "<div class=\"pictures\">\n";
    for (std::size_t i = 0; i < pictures.size(); ++i) html += Figure(pictures[i], links[i]);
    html +=
        "</div>\n<ul class=\"legend\"><li><i class=\"covered\"></i>covered</li><li><i "
        "class=\"uncovered\"></i>uncovered: more photos are needed</li><li><i "
        "class=\"ignored\"></i>ignored: outside the region</li></ul>\n";
  }
  return html + Unregistered(iteration) + "</section>\n";
}

// Copies a picture unless the copy is already there and newer. Returns its link from the page.
std::string CopyPicture(const fs::path& file, std::size_t iteration, const fs::path& folder) {
  RequireFile(file, "picture");
  char prefix[32];
  std::snprintf(prefix, sizeof prefix, "%03zu_", iteration);
  const std::string link = "pictures/" + (prefix + file.filename().string());
  const fs::path target = folder / link;
  std::error_code error;
  const bool is_fresh = fs::is_regular_file(target, error) &&
                        fs::file_size(target, error) == fs::file_size(file, error) &&
                        fs::last_write_time(target, error) >= fs::last_write_time(file, error);
  if (!is_fresh || error) WriteFileAtomically(target, ReadFile(file));
  return link;
}

}  // namespace

void WriteReportPage(const ReportInput& input, const fs::path& folder,
                     const std::string& page_name) {
  const SessionSummary& summary = input.summary;
  if (input.pictures.size() != summary.iterations.size()) {
    throw Error("report: pictures of " + std::to_string(input.pictures.size()) +
                " iterations for a summary of " + std::to_string(summary.iterations.size()));
  }
  std::string body;
  for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
    std::vector<std::string> links;
    for (const ReportPicture& picture : input.pictures[i]) {
      links.push_back(CopyPicture(picture.file, i, folder));
    }
    body += IterationSection(i, summary.iterations[i], input.pictures[i], links);
  }
  const std::string title = EscapeHtml(input.title);
  const std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      title + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>" + kPageStyle +
      "</style>\n</head>\n<body>\n<header><h1>" + title + "</h1><p class=\"soft\">" +
      EscapeHtml(FinishedSentence(summary.finished)) + "</p></header>\n<main>\n" + Tiles(summary) +
      Charts(summary) + Table(summary) + Navigation(summary.iterations.size()) + body +
      "</main>\n<dialog aria-label=\"Picture\"><img alt=\"\"><p></p><small>left, right: other "
      "pictures; up, down: same picture of another iteration; Esc: close</small></dialog>\n"
      "<script>" +
      kPageScript + "</script>\n</body>\n</html>\n";
  WriteFileAtomically(folder / page_name, html);
}

}  // namespace colmap_ext
