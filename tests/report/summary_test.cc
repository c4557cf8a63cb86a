#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/error.h"
#include "report/made_up_session.h"

namespace colmap_ext {
namespace {

std::filesystem::path TemporaryFile(const std::string& content) {
  const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto path = std::filesystem::path(::testing::TempDir()) / ("summary_" + name + ".json");
  std::ofstream(path) << content;
  return path;
}

void ExpectEqual(const SessionSummary& a, const SessionSummary& b) {
  EXPECT_EQ(a.finished, b.finished);
  ASSERT_EQ(a.iterations.size(), b.iterations.size());
  for (std::size_t i = 0; i < a.iterations.size(); ++i) {
    const IterationSummary &x = a.iterations[i], &y = b.iterations[i];
    EXPECT_EQ(x.photos, y.photos);
    EXPECT_EQ(x.registered, y.registered);
    EXPECT_EQ(x.covered_ratio, y.covered_ratio);
    EXPECT_EQ(x.reachable_covered_ratio, y.reachable_covered_ratio);
    EXPECT_EQ(x.planned_views, y.planned_views);
    EXPECT_EQ(x.mean_error_m, y.mean_error_m);
    EXPECT_EQ(x.rms_error_m, y.rms_error_m);
    EXPECT_EQ(x.wall_s, y.wall_s);
    EXPECT_EQ(x.stage_wall_s, y.stage_wall_s);
    EXPECT_EQ(x.unregistered, y.unregistered);
    ASSERT_EQ(x.completeness.size(), y.completeness.size());
    for (std::size_t k = 0; k < x.completeness.size(); ++k) {
      EXPECT_EQ(x.completeness[k].key, y.completeness[k].key);
      EXPECT_EQ(x.completeness[k].share, y.completeness[k].share);
    }
  }
}

TEST(SummaryJson, ComesBackExactly) {
  const auto path = TemporaryFile("");
  WriteSummary(MadeUpSession(4), path);
  ExpectEqual(ReadSummary(path), MadeUpSession(4));
  WriteSummary({}, path);
  ExpectEqual(ReadSummary(path), {});
}

TEST(SummaryJson, HasTheDocumentedNames) {
  const auto path = TemporaryFile("");
  WriteSummary(MadeUpSession(2), path);
  const Json json = ReadJsonFile(path);
  EXPECT_EQ(json.at("finished"), "covered");
  const Json& row = json.at("iterations").at(1);
  EXPECT_EQ(row.at("photos"), 72);
  EXPECT_EQ(row.at("registered"), 70);
  for (const char* name : {"covered_ratio", "mean_error_m", "rms_error_m", "wall_s"}) {
    EXPECT_TRUE(row.at(name).is_number()) << name;
  }
  EXPECT_TRUE(row.at("completeness").at("25.4mm").is_number());
}

TEST(SummaryJson, ErrorsNameThePlace) {
  const auto message = [](const std::string& text) -> std::string {
    const auto path = TemporaryFile(text);
    try {
      ReadSummary(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(message("{\"finished\": \"x\", \"iterations\": [{\"photos\": 3}]}").find("registered"),
            std::string::npos);
  EXPECT_NE(message("{\"finished\": \"x\", \"iterations\": [{\"photos\": \"3\"}]}")
                .find("/iterations/0/photos"),
            std::string::npos);
  EXPECT_NE(message("{\"finished\": \"x\", \"iterations\": {}}").find("/iterations"),
            std::string::npos);
  EXPECT_NE(message("{\"finished").find(".json"), std::string::npos);
  EXPECT_NE(message("[]"), "no error");
}

TEST(StageSeconds, AreReadFromTimingJson) {
  const auto path = TemporaryFile(
      "{\"sparse\": {\"wall_s\": 2.5, \"cpu_s\": 4, \"peak_mib\": 10}, \"nbv\": {\"wall_s\": 1}}");
  const std::map<std::string, double> expected = {{"nbv", 1.0}, {"sparse", 2.5}};
  EXPECT_EQ(ReadStageSeconds(path), expected);
  EXPECT_THROW(ReadStageSeconds(TemporaryFile("{\"sparse\": {}}")), Error);
  EXPECT_THROW(ReadStageSeconds(TemporaryFile("[]")), Error);
}

TEST(SummaryTable, IsAligned) {
  const std::string table = SummaryTable(MadeUpSession(12));
  std::istringstream stream(table);
  std::vector<std::size_t> lengths;
  std::string line;
  while (std::getline(stream, line) && !line.empty()) {
    lengths.push_back(line.size());
    EXPECT_LE(line.size(), 100u);
  }
  ASSERT_GE(lengths.size(), 14u);
  for (const std::size_t length : lengths) EXPECT_EQ(length, lengths.front());
  EXPECT_NE(table.find("what can be reached is covered"), std::string::npos);
}

TEST(SummaryTable, HasTheNumbers) {
  const SummaryCells cells = MakeSummaryCells(MadeUpSession(2));
  ASSERT_EQ(cells.rows.size(), 2u);
  const auto cell = [&](const std::string& title) -> std::string {
    for (std::size_t k = 0; k < cells.titles.size(); ++k) {
      if (cells.titles[k] == title) return cells.rows[1][k];
    }
    return "no such column";
  };
  EXPECT_EQ(cell("iteration"), "1");
  EXPECT_EQ(cell("photos"), "72");
  EXPECT_EQ(cell("registered"), "70");
  EXPECT_EQ(cell("covered %"), "75.0");
  EXPECT_EQ(cell("reachable covered %"), "80.0");
  EXPECT_EQ(cell("mean error mm"), "40.0");
  EXPECT_EQ(cell("within 25.4mm %"), "40.0");
  EXPECT_EQ(cell("sparse s"), "30.5");
  EXPECT_EQ(cell("total s"), "62.0");
}

TEST(SummaryTable, UnknownColumnsAreLeftOutAndGapsMarked) {
  SessionSummary summary = MadeUpSession(2);
  for (IterationSummary& iteration : summary.iterations) {
    iteration.mean_error_m.reset();
    iteration.rms_error_m.reset();
    iteration.completeness.clear();
  }
  summary.iterations[1].covered_ratio.reset();
  const SummaryCells cells = MakeSummaryCells(summary);
  for (const std::string& title : cells.titles) {
    EXPECT_EQ(title.find("error"), std::string::npos);
    EXPECT_EQ(title.find("within"), std::string::npos);
  }
  EXPECT_EQ(cells.titles[3], "covered %");
  EXPECT_EQ(cells.rows[1][3], "-");
  EXPECT_FALSE(SummaryTable({}).empty());
}

TEST(StagesOf, RunInTheirOrder) {
  SessionSummary summary;
  summary.iterations.resize(2);
  summary.iterations[0].stage_wall_s = {{"path", 1}, {"sparse", 1}, {"extra", 1}};
  summary.iterations[1].stage_wall_s = {{"nbv", 1}};
  EXPECT_EQ(StagesOf(summary), (std::vector<std::string>{"sparse", "nbv", "path", "extra"}));
}

}  // namespace
}  // namespace colmap_ext
