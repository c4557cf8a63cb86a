#include "colmap_ext/sfm/colmap_dialect.h"

#include <gtest/gtest.h>

#include <map>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Help texts reduced to the facts that matter: which version has which command and option.
std::string HelpOf(const std::string& version, const std::vector<std::string>& commands) {
  std::string help = "COLMAP " + version + " -- Structure-from-Motion and Multi-View Stereo\n" +
                     "Example usage:\n  colmap help [ -h, --help ]\n\nAvailable commands:\n";
  for (const std::string& command : commands) help += "  " + command + "\n";
  return help;
}

std::string OptionHelp(const std::vector<std::string>& options) {
  std::string help = "  -h [ --help ]\n";
  for (const std::string& option : options) help += "  --" + option + " arg (=1)\n";
  return help;
}

using Helps = std::map<std::string, std::string>;

Helps Version38() {
  return {{"help", HelpOf("3.8", {"feature_extractor", "matches_importer", "mapper"})},
          {"feature_extractor", OptionHelp({"image_list_path", "SiftExtraction.use_gpu"})},
          {"matches_importer", OptionHelp({"SiftMatching.use_gpu", "SiftMatching.max_error"})},
          {"mapper", OptionHelp({"image_list_path", "Mapper.fix_existing_images",
                                 "Mapper.ba_global_images_ratio", "Mapper.extract_colors"})}};
}

Helps Version310() {
  Helps helps = Version38();
  helps["help"] = "I20250101 12:00:00.1 1 colmap.cc:1] start\n" +
                  HelpOf("3.10", {"feature_extractor", "matches_importer", "mapper"});
  return helps;
}

Helps Version42() {
  return {
      {"help", HelpOf("4.2.1", {"feature_extractor", "matches_importer", "mapper", "global_mapper",
                                "geometric_verifier"})},
      {"feature_extractor", OptionHelp({"image_list_path", "FeatureExtraction.use_gpu"})},
      {"matches_importer", OptionHelp({"FeatureMatching.use_gpu", "TwoViewGeometry.max_error"})},
      {"mapper", OptionHelp({"Mapper.image_list_path", "Mapper.fix_existing_frames",
                             "Mapper.ba_global_frames_ratio"})}};
}

ColmapDialect DialectOf(const Helps& helps) {
  return ColmapDialect([helps](const std::string& command) { return helps.at(command); });
}

using Strings = std::vector<std::string>;

TEST(ColmapDialect, ReadsTheVersion) {
  EXPECT_EQ(DialectOf(Version38()).version(), "3.8");
  EXPECT_EQ(DialectOf(Version310()).version(), "3.10");
  EXPECT_EQ(DialectOf(Version42()).version(), "4.2.1");
}

TEST(ColmapDialect, KeepsTheSpellingOf38) {
  ColmapDialect dialect = DialectOf(Version38());
  EXPECT_EQ(dialect.Arguments("feature_extractor", {{"SiftExtraction.use_gpu", "0"}}),
            (Strings{"--SiftExtraction.use_gpu", "0"}));
  EXPECT_EQ(dialect.Arguments("mapper", {{"Mapper.fix_existing_images", "1"}}),
            (Strings{"--Mapper.fix_existing_images", "1"}));
}

TEST(ColmapDialect, SpellsAs4xDoes) {
  ColmapDialect dialect = DialectOf(Version42());
  EXPECT_EQ(dialect.Arguments("feature_extractor",
                              {{"image_list_path", "a"}, {"SiftExtraction.use_gpu", "0"}}),
            (Strings{"--image_list_path", "a", "--FeatureExtraction.use_gpu", "0"}));
  EXPECT_EQ(dialect.Arguments("matches_importer",
                              {{"SiftMatching.use_gpu", "0"}, {"SiftMatching.max_error", "2"}}),
            (Strings{"--FeatureMatching.use_gpu", "0", "--TwoViewGeometry.max_error", "2"}));
  EXPECT_EQ(dialect.Arguments("mapper", {{"image_list_path", "a"},
                                         {"Mapper.fix_existing_images", "1"},
                                         {"Mapper.ba_global_images_ratio", "1.4"}}),
            (Strings{"--Mapper.image_list_path", "a", "--Mapper.fix_existing_frames", "1",
                     "--Mapper.ba_global_frames_ratio", "1.4"}));
}

TEST(ColmapDialect, LeavesOutWhatOnlyTunesAndRefusesWhatTheResultNeeds) {
  ColmapDialect dialect = DialectOf(Version42());
  EXPECT_TRUE(dialect.Arguments("mapper", {{"Mapper.extract_colors", "0"}}).empty());
  try {
    dialect.Arguments("matches_importer", {{"match_type", "raw"}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--match_type"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("4.2.1"), std::string::npos);
  }
}

TEST(ColmapDialect, KnowsCommandsAndOptions) {
  ColmapDialect dialect = DialectOf(Version42());
  EXPECT_TRUE(dialect.HasCommand("geometric_verifier"));
  EXPECT_FALSE(DialectOf(Version38()).HasCommand("geometric_verifier"));
  EXPECT_TRUE(dialect.HasOption("mapper", "Mapper.fix_existing_images"));
  EXPECT_FALSE(dialect.HasOption("mapper", "Mapper.extract_colors"));
  EXPECT_FALSE(dialect.HasOption("nothing", "x"));
  EXPECT_THROW(dialect.Arguments("nothing", {}), Error);
}

TEST(ColmapDialect, AsksForEachHelpTextOnce) {
  int asked = 0;
  const Helps helps = Version38();
  ColmapDialect dialect([&](const std::string& command) {
    ++asked;
    return helps.at(command);
  });
  for (int i = 0; i < 3; ++i) dialect.HasOption("mapper", "image_list_path");
  EXPECT_EQ(asked, 2);
}

TEST(ColmapDialect, RefusesAProgramThatIsNotColmap) {
  EXPECT_THROW(DialectOf({{"help", "usage: something else"}}), Error);
  EXPECT_THROW(DialectOf({{"help", ""}}), Error);
}

}  // namespace
}  // namespace colmap_ext
