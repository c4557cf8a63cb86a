#include "colmap_ext/util/options.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {
namespace fs = std::filesystem;

struct Values {
  fs::path image_path;
  int count = 5;
  double angle_deg = 15.25;
  bool fast = true;
  std::uint64_t seed = 7;
};

void Bind(OptionSet& set, Values* values) {
  set.Add("", "image_path", &values->image_path, "folder of photos");
  set.Add("Search", "count", &values->count, "how many");
  set.Add("Search", "angle_deg", &values->angle_deg, "limit");
  set.Add("Search", "fast", &values->fast, "skip");
  set.Add("Other", "seed", &values->seed, "of the dice");
}

std::string ComplaintOf(const std::vector<std::string>& arguments) {
  Values values;
  OptionSet set;
  Bind(set, &values);
  try {
    set.Parse(arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Options, ParsesEveryType) {
  Values values;
  OptionSet set;
  Bind(set, &values);
  set.Parse({"--image_path", "some where", "--Search.count=-3", "--Search.angle_deg", "-1e-3",
             "--Search.fast", "0", "--Other.seed", "18446744073709551615"});
  EXPECT_EQ(values.image_path, "some where");
  EXPECT_EQ(values.count, -3);
  EXPECT_EQ(values.angle_deg, -1e-3);
  EXPECT_FALSE(values.fast);
  EXPECT_EQ(values.seed, 18446744073709551615ULL);
  EXPECT_TRUE(set.IsSet("Search.count"));
}

TEST(Options, NamesWhatIsWrong) {
  const std::string misspelt = ComplaintOf({"--Search.cuont", "3"});
  EXPECT_NE(misspelt.find("Search.cuont"), std::string::npos) << misspelt;
  EXPECT_NE(misspelt.find("did you mean Search.count?"), std::string::npos) << misspelt;
  EXPECT_EQ(ComplaintOf({"--magic", "3"}).find("did you mean"), std::string::npos);
  EXPECT_NE(ComplaintOf({"--Search.count", "3x"}).find("'3x' is not a whole number"),
            std::string::npos);
  EXPECT_NE(ComplaintOf({"--Search.fast", "maybe"}).find("--Search.fast"), std::string::npos);
  EXPECT_NE(ComplaintOf({"--Search.count"}), "");
  EXPECT_NE(ComplaintOf({"stray"}), "");
  EXPECT_NE(ComplaintOf({"--Other.seed", "-1"}), "");
  EXPECT_NE(ComplaintOf({"--Search.cou", "3"}), "") << "abbreviations must not be guessed";
}

TEST(Options, IniRoundTripAndPrecedence) {
  const fs::path path = fs::path(testing::TempDir()) / ("o" + std::to_string(getpid()) + ".ini");
  Values written;
  written.angle_deg = 0.1;
  written.count = 9;
  OptionSet writer;
  Bind(writer, &written);
  WriteFileAtomically(path, "# comment\nimage_path = from ini\n\n" + writer.ToIni());

  Values values;
  OptionSet set;
  Bind(set, &values);
  set.Parse({"--Search.count", "11", "--project_path", path.string()});
  EXPECT_EQ(values.count, 11) << "the command line wins";
  EXPECT_EQ(values.angle_deg, 0.1);
  EXPECT_EQ(values.image_path, "from ini");
  fs::remove(path);
}

TEST(Options, IniErrorsNameTheLine) {
  const fs::path path = fs::path(testing::TempDir()) / ("e" + std::to_string(getpid()) + ".ini");
  WriteFileAtomically(path, "[Unused]\nanything = 1\n[Search]\nwrong = 2\n");
  const std::string complaint = ComplaintOf({"--project_path", path.string()});
  EXPECT_NE(complaint.find(path.string() + ":4"), std::string::npos) << complaint;
  WriteFileAtomically(path, "[Search]\nanlge_deg = 2\n");
  EXPECT_NE(ComplaintOf({"--project_path", path.string()}).find("did you mean Search.angle_deg?"),
            std::string::npos);
  WriteFileAtomically(path, "[Search]\ncount = many\n");
  EXPECT_NE(ComplaintOf({"--project_path", path.string()}).find(":2"), std::string::npos);
  fs::remove(path);
}

TEST(Options, HelpShowsDefaults) {
  Values values;
  OptionSet set;
  Bind(set, &values);
  set.Parse({"-h"});
  EXPECT_TRUE(set.HelpRequested());
  EXPECT_NE(set.HelpText().find("15.25"), std::string::npos);
  EXPECT_NE(set.HelpText().find("Search.angle_deg"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
