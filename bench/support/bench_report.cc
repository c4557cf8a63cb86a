#include "bench_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <utility>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

std::string CpuName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

double MemoryGib() {
  std::ifstream info("/proc/meminfo");
  std::string label;
  double kib = 0;
  info >> label >> kib;
  return std::round(kib / (1024.0 * 1024.0) * 10) / 10;
}

// Of the folder that the benchmark is run from; "unknown" outside a checkout.
std::string Commit() {
  std::string text;
  if (FILE* pipe = popen("git describe --always --dirty --abbrev=12 2>/dev/null", "r")) {
    std::array<char, 128> buffer{};
    while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) {
      text += buffer.data();
    }
    pclose(pipe);
  }
  while (!text.empty() && text.back() == '\n') {
    text.pop_back();
  }
  return text.empty() ? "unknown" : text;
}

std::string Number(double value) {
  std::ostringstream out;
  out << std::setprecision(4) << value;
  return out.str();
}

std::string GoalText(const BenchGoal& goal) {
  return (goal.kind == BenchGoal::Kind::kAtMost ? "<= " : ">= ") + Number(goal.value);
}

bool IsMet(const BenchGoal& goal, double value) {
  return goal.kind == BenchGoal::Kind::kAtMost ? value <= goal.value : value >= goal.value;
}

std::string MarkdownRow(const BenchRow& row) {
  std::string text = "| " + row.name + " | " + Number(row.value) + " | " + row.unit + " | ";
  if (row.goal) {
    text += GoalText(*row.goal) + " | " + (IsMet(*row.goal, row.value) ? "yes" : "**no**");
  } else {
    text += "| ";
  }
  return text + " |";
}

}  // namespace

BenchGoal AtMost(double value) { return {BenchGoal::Kind::kAtMost, value}; }
BenchGoal AtLeast(double value) { return {BenchGoal::Kind::kAtLeast, value}; }

BenchReport::BenchReport(std::string name) : name_(std::move(name)) {
  std::cout << "| " << name_ << " | value | unit | goal | met |\n|---|---|---|---|---|"
            << std::endl;
}

void BenchReport::Add(const std::string& row_name, double value, const std::string& unit,
                      const std::optional<BenchGoal>& goal) {
  rows_.push_back({row_name, value, unit, goal});
  std::cout << MarkdownRow(rows_.back()) << std::endl;
}

std::string BenchReport::ToMarkdown() const {
  std::string text = "| " + name_ + " | value | unit | goal | met |\n|---|---|---|---|---|\n";
  for (const BenchRow& row : rows_) {
    text += MarkdownRow(row) + "\n";
  }
  return text;
}

std::string BenchReport::ToJson() const {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BenchRow& row : rows_) {
    nlohmann::ordered_json entry = {{"name", row.name}, {"value", row.value}, {"unit", row.unit}};
    entry["goal"] = row.goal ? nlohmann::ordered_json(GoalText(*row.goal)) : nullptr;
    entry["met"] = row.goal ? nlohmann::ordered_json(IsMet(*row.goal, row.value)) : nullptr;
    rows.push_back(std::move(entry));
  }
  const nlohmann::ordered_json machine = {{"cpu", CpuName()},
                                          {"cores", std::thread::hardware_concurrency()},
                                          {"memory_gib", MemoryGib()}};
  const nlohmann::ordered_json report = {
      {"machine", machine}, {"commit", Commit()}, {"rows", rows}};
  return report.dump(2) + "\n";
}

void BenchReport::Write(const std::filesystem::path& folder) const {
  WriteFileAtomically(folder / (name_ + ".json"), ToJson());
}

double Median(std::vector<double> values) {
  if (values.empty()) {
    throw Error("a median needs at least one value");
  }
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace colmap_ext
