#include "colmap_ext/report/report_page.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "report/html_text.h"
#include "report/line_chart.h"
#include "report/made_up_session.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// A workspace with a summary and pictures, whose name and one of whose pictures need escaping.
class ReportPageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(::testing::TempDir()) /
            (std::string("report <page> & \"test\" ") +
             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    WriteSummary(MadeUpSession(3), Workspace(root_).summary_json());
    for (int i = 0; i < 3; ++i) {
      for (const std::string& name : ReportPictureNames()) WritePicture(i, name);
    }
    WritePicture(1, "100% <odd> & \"name\".png");
  }
  void TearDown() override { fs::remove_all(root_); }

  void WritePicture(int iteration, const std::string& name) const {
    const cv::Mat picture(8, 8, CV_8UC3, cv::Scalar::all(20 * iteration));
    WritePng(picture, IterationFiles{Workspace(root_).iteration(iteration)}.pictures() / name);
  }

  std::string WriteAndReadPage() const {
    const Workspace workspace(root_);
    WriteReportPage(ReadReportInput(workspace), workspace.report());
    return ReadFile(workspace.report() / "index.html");
  }

  fs::path root_;
};

std::size_t CountOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string DecodeUrl(const std::string& url) {
  std::string text;
  for (std::size_t i = 0; i < url.size(); ++i) {
    if (url[i] == '%') {
      text += static_cast<char>(std::stoi(url.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += url[i];
    }
  }
  return text;
}

TEST_F(ReportPageTest, ShowsEveryIterationWithItsPictures) {
  const std::string page = WriteAndReadPage();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(CountOf(page, "<section data-iteration=\"" + std::to_string(i) + "\">"), 1u);
  }
  EXPECT_EQ(CountOf(page, "<figure "), 16u);
  EXPECT_EQ(CountOf(page, "Coverage map</figcaption>"), 3u);
  EXPECT_EQ(CountOf(page, "<svg class=\"chart\""), 3u);
  EXPECT_NE(page.find("what can be reached is covered"), std::string::npos);
  EXPECT_NE(page.find("70 of 72 photos registered"), std::string::npos);
}

TEST_F(ReportPageTest, KnownPicturesComeInOrder) {
  const ReportInput input = ReadReportInput(Workspace(root_));
  ASSERT_EQ(input.pictures.size(), 3u);
  ASSERT_EQ(input.pictures[1].size(), 6u);
  EXPECT_EQ(input.pictures[1][0].file.filename(), "superpixels.png");
  EXPECT_EQ(input.pictures[1][3].title, "Coverage map");
  EXPECT_EQ(input.pictures[1][5].title, "100% <odd> & \"name\"");
  EXPECT_EQ(input.title, root_.filename().string());
}

TEST_F(ReportPageTest, EveryLinkIsRelativeAndLeadsToAPicture) {
  const std::string page = WriteAndReadPage();
  const std::regex link("src=\"([^\"]*)\"");
  std::size_t count = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), link), end; it != end; ++it, ++count) {
    const std::string target = DecodeUrl((*it)[1]);
    EXPECT_EQ(target.find("pictures/"), 0u) << target;
    EXPECT_TRUE(fs::is_regular_file(Workspace(root_).report() / target)) << target;
  }
  EXPECT_EQ(count, 16u);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
}

TEST_F(ReportPageTest, NamesAreEscaped) {
  const std::string page = WriteAndReadPage();
  EXPECT_EQ(page.find("<odd>"), std::string::npos);
  EXPECT_EQ(page.find("<page>"), std::string::npos);
  EXPECT_EQ(page.find("a <b>"), std::string::npos);
  EXPECT_NE(page.find("a &lt;b&gt;&amp;&quot;c&#39;.jpg"), std::string::npos);
  EXPECT_NE(page.find("report &lt;page&gt; &amp; &quot;test&quot; NamesAreEscaped</h1>"),
            std::string::npos);
}

TEST_F(ReportPageTest, ChangedPicturesAreCopiedAgain) {
  WriteAndReadPage();
  const fs::path copy = Workspace(root_).report() / "pictures" / "000_surface.png";
  const std::string before = ReadFile(copy);
  WritePng(cv::Mat(9, 9, CV_8UC3, cv::Scalar(1, 2, 3)),
           IterationFiles{Workspace(root_).iteration(0)}.pictures() / "surface.png");
  WriteAndReadPage();
  EXPECT_NE(ReadFile(copy), before);
}

TEST_F(ReportPageTest, SecondsComeFromTimingJsonWhereTheSummaryLacksThem) {
  SessionSummary summary = MadeUpSession(3);
  for (auto& iteration : summary.iterations) iteration.stage_wall_s.clear();
  const Workspace workspace(root_);
  WriteSummary(summary, workspace.summary_json());
  WriteFileAtomically(IterationFiles{workspace.iteration(2)}.timing_json(),
                      "{\"surface\": {\"wall_s\": 12.5}}");
  const ReportInput input = ReadReportInput(workspace);
  EXPECT_TRUE(input.summary.iterations[0].stage_wall_s.empty());
  EXPECT_EQ(input.summary.iterations[2].stage_wall_s.at("surface"), 12.5);
}

TEST_F(ReportPageTest, ClearErrors) {
  EXPECT_THROW(ReadReportInput(Workspace(root_ / "nothing")), Error);
  fs::create_directories(root_ / "empty");
  EXPECT_THROW(ReadReportInput(Workspace(root_ / "empty")), Error);
  ReportInput input = ReadReportInput(Workspace(root_));
  input.pictures[0][0].file = root_ / "gone.png";
  EXPECT_THROW(WriteReportPage(input, root_ / "out"), Error);
  EXPECT_FALSE(fs::exists(root_ / "out" / "index.html"));
  input.pictures.pop_back();
  EXPECT_THROW(WriteReportPage(input, root_ / "out"), Error);
}

TEST_F(ReportPageTest, AnEmptySessionHasAPage) {
  WriteReportPage({"empty", {}, {}}, root_ / "out");
  EXPECT_NE(ReadFile(root_ / "out" / "index.html").find("has not ended yet"), std::string::npos);
}

TEST(EscapeHtml, AllFive) {
  EXPECT_EQ(EscapeHtml("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(EncodeUrlPath("p/a b%#?.png"), "p/a%20b%25%23%3F.png");
  EXPECT_EQ(EncodeUrlPath("\xc3\xa4"), "%C3%A4");
}

TEST(LineChartSvg, PointsStandAtTheirValues) {
  LineChart chart{"t", " %", {{"a", "series-1", {0.0, std::nullopt, 100.0}}}, 0, 100};
  const std::string svg = LineChartSvg(chart);
  EXPECT_EQ(CountOf(svg, "<circle "), 2u);
  EXPECT_NE(svg.find("cx=\"46\" cy=\"190\""), std::string::npos);  // left, on the axis
  EXPECT_NE(svg.find("cx=\"382\" cy=\"14\""), std::string::npos);  // right, at the top
  EXPECT_EQ(CountOf(svg, "M"), 2u);                                // the gap is left open
  EXPECT_NE(svg.find("<title>Iteration 2: a 100 %</title>"), std::string::npos);
  chart.series[0].values = {std::nullopt};
  EXPECT_EQ(LineChartSvg(chart), "");
}

}  // namespace
}  // namespace colmap_ext
