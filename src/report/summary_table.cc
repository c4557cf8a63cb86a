#include "colmap_ext/report/summary_table.h"

#include <algorithm>
#include <functional>
#include <sstream>

#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

std::string Format(const char* format, const std::optional<double>& value, double factor) {
  return value ? FormatNumber(format, *value * factor) : "-";
}

// A column: its title, and its cell for the i-th iteration.
struct Column {
  std::string title;
  std::function<std::string(const IterationSummary&, std::size_t index)> cell;
};

std::vector<std::string> CompletenessKeys(const SessionSummary& summary) {
  std::vector<std::string> keys;
  for (const IterationSummary& iteration : summary.iterations) {
    for (const CompletenessValue& value : iteration.completeness) {
      if (std::find(keys.begin(), keys.end(), value.key) == keys.end()) keys.push_back(value.key);
    }
  }
  return keys;
}

std::vector<Column> MakeColumns(const SessionSummary& summary) {
  using Row = const IterationSummary&;
  std::vector<Column> columns = {
      {"iteration", [](Row, std::size_t index) { return std::to_string(index); }},
      {"photos", [](Row row, std::size_t) { return std::to_string(row.photos); }},
      {"registered", [](Row row, std::size_t) { return std::to_string(row.registered); }},
      {"covered %", [](Row row, std::size_t) { return Format("%.1f", row.covered_ratio, 100); }},
      {"reachable covered %",
       [](Row row, std::size_t) { return Format("%.1f", row.reachable_covered_ratio, 100); }},
      {"mean error mm",
       [](Row row, std::size_t) { return Format("%.1f", row.mean_error_m, 1000); }},
      {"RMS error mm", [](Row row, std::size_t) { return Format("%.1f", row.rms_error_m, 1000); }}};
  for (const std::string& key : CompletenessKeys(summary)) {
    columns.push_back({"within " + key + " %", [key](Row row, std::size_t) {
                         for (const CompletenessValue& value : row.completeness) {
                           if (value.key == key) return FormatNumber("%.1f", 100 * value.share);
                         }
                         return std::string("-");
                       }});
  }
  for (const std::string& stage : StagesOf(summary)) {
    columns.push_back({stage + " s", [stage](Row row, std::size_t) {
                         const auto found = row.stage_wall_s.find(stage);
                         return found == row.stage_wall_s.end()
                                    ? std::string("-")
                                    : FormatNumber("%.1f", found->second);
                       }});
  }
  columns.push_back(
      {"total s", [](Row row, std::size_t) { return FormatNumber("%.1f", row.wall_s); }});
  return columns;
}

// The words of each title under one another, the last one on the last line.
std::vector<std::vector<std::string>> TitleLines(const std::vector<std::string>& titles) {
  std::vector<std::vector<std::string>> words_of_title;
  std::size_t height = 0;
  for (const std::string& title : titles) {
    std::istringstream stream(title);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    height = std::max(height, words.size());
    words_of_title.push_back(words);
  }
  std::vector<std::vector<std::string>> lines(height, std::vector<std::string>(titles.size()));
  for (std::size_t k = 0; k < titles.size(); ++k) {
    const std::vector<std::string>& words = words_of_title[k];
    for (std::size_t i = 0; i < words.size(); ++i) lines[height - words.size() + i][k] = words[i];
  }
  return lines;
}

// The chosen columns as right-aligned text.
std::string AlignedText(const SummaryCells& cells, const std::vector<std::size_t>& columns) {
  const auto chosen = [&](const std::vector<std::string>& line) {
    std::vector<std::string> part;
    for (const std::size_t k : columns) part.push_back(line[k]);
    return part;
  };
  std::vector<std::vector<std::string>> lines = TitleLines(chosen(cells.titles));
  lines.emplace_back();  // the rule, once widths are known
  const std::size_t rule = lines.size() - 1;
  for (const auto& row : cells.rows) lines.push_back(chosen(row));
  std::vector<std::size_t> widths(columns.size(), 0);
  for (const auto& line : lines) {
    for (std::size_t k = 0; k < line.size(); ++k) widths[k] = std::max(widths[k], line[k].size());
  }
  for (const std::size_t width : widths) lines[rule].emplace_back(width, '-');
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t k = 0; k < line.size(); ++k) {
      text += std::string(k == 0 ? 0 : 2, ' ') + std::string(widths[k] - line[k].size(), ' ');
      text += line[k];
    }
    text += "\n";
  }
  return text;
}

}  // namespace

SummaryCells MakeSummaryCells(const SessionSummary& summary) {
  SummaryCells cells;
  cells.rows.resize(summary.iterations.size());
  for (const Column& column : MakeColumns(summary)) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < summary.iterations.size(); ++i) {
      values.push_back(column.cell(summary.iterations[i], i));
    }
    const bool is_empty = !values.empty() && std::all_of(values.begin(), values.end(),
                                                         [](auto& value) { return value == "-"; });
    if (is_empty) continue;
    cells.titles.push_back(column.title);
    for (std::size_t i = 0; i < values.size(); ++i) cells.rows[i].push_back(values[i]);
  }
  return cells;
}

std::string SummaryTable(const SessionSummary& summary) {
  const SummaryCells cells = MakeSummaryCells(summary);
  // The seconds of the stages stand below, so that lines fit on a terminal.
  std::vector<std::size_t> results, seconds;
  for (std::size_t k = 0; k < cells.titles.size(); ++k) {
    const bool is_seconds = cells.titles[k].ends_with(" s");
    if (k == 0 || !is_seconds) results.push_back(k);
    if (k == 0 || is_seconds) seconds.push_back(k);
  }
  return AlignedText(cells, results) + "\n" + AlignedText(cells, seconds) + "\n" +
         FinishedSentence(summary.finished) + "\n";
}

}  // namespace colmap_ext
