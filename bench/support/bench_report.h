// What a benchmark prints: a Markdown table, and bench/results/<name>.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace colmap_ext {

struct BenchGoal {
  enum class Kind { kAtMost, kAtLeast };
  Kind kind = Kind::kAtMost;
  double value = 0;
};

struct BenchRow {
  std::string name;  // unique in the report
  double value = 0;
  std::string unit;  // "s", "CPU s", "ratio", "%", "mm" …
  std::optional<BenchGoal> goal;
};

BenchGoal AtMost(double value);
BenchGoal AtLeast(double value);

// Collects what was measured, in order.
class BenchReport {
 public:
  // `name`: that of the benchmark, for example "sfm"; also the file's.
  explicit BenchReport(std::string name);

  // Adds the row and prints it at once, so that a long run shows what it has.
  void Add(const std::string& row_name, double value, const std::string& unit,
           const std::optional<BenchGoal>& goal = std::nullopt);

  const std::vector<BenchRow>& rows() const { return rows_; }
  std::string ToMarkdown() const;
  // {"machine": {"cpu", "cores", "memory_gib"}, "commit", "rows": [{"name", "value", "unit",
  // "goal": "<= 1", "met": true}]}; goal and met are null where there is no goal.
  std::string ToJson() const;
  // Writes <folder>/<name>.json, atomically.
  void Write(const std::filesystem::path& folder) const;

 private:
  std::string name_;
  std::vector<BenchRow> rows_;
};

// Middle value (mean of the two middle ones for an even count); throws Error when empty.
double Median(std::vector<double> values);

}  // namespace colmap_ext
