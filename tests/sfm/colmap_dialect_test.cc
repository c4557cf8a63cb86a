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
using Strings = std::vector<std::string>;

const Strings& Commands() {
  static const Strings commands = {"feature_extractor", "matches_importer", "mapper",
                                   "bundle_adjuster", "model_aligner"};
  return commands;
}

// Facts of Debian 12's colmap 3.8.
Helps Version38() {
  return {
      {"help", HelpOf("3.8", Commands())},
      {"feature_extractor",
       OptionHelp({"random_seed", "image_list_path", "SiftExtraction.use_gpu",
                   "SiftExtraction.num_threads", "SiftExtraction.max_image_size",
                   "SiftExtraction.first_octave"})},
      {"matches_importer",
       OptionHelp({"random_seed", "match_type", "SiftMatching.use_gpu", "SiftMatching.max_error"})},
      {"mapper", OptionHelp({"random_seed", "image_list_path", "Mapper.fix_existing_images",
                             "Mapper.ba_global_images_ratio", "Mapper.extract_colors"})},
      {"bundle_adjuster",
       OptionHelp({"BundleAdjustment.max_num_iterations", "BundleAdjustment.refine_extrinsics"})},
      {"model_aligner", OptionHelp({"ref_is_gps", "alignment_type", "robust_alignment",
                                    "robust_alignment_max_error"})}};
}

// Of Debian 13's, 3.10-dev.
Helps Version310() {
  Helps helps = Version38();
  Strings commands = Commands();
  commands.push_back("pose_prior_mapper");
  helps["help"] = "I20250101 12:00:00.1 1 colmap.cc:1] start\n" + HelpOf("3.10-dev", commands);
  helps["matches_importer"] = OptionHelp(
      {"random_seed", "match_type", "SiftMatching.use_gpu", "TwoViewGeometry.max_error"});
  helps["model_aligner"] = OptionHelp({"ref_is_gps", "alignment_type", "alignment_max_error"});
  return helps;
}

// Of Debian unstable's, 4.2.1.
Helps Version42() {
  Strings commands = Commands();
  commands.insert(commands.end(), {"global_mapper", "geometric_verifier", "pose_prior_mapper"});
  return {{"help", "I20260101 12:00:00.1 1 option_manager.cc:1] COLMAP 4.2.1 (Commit Unknown)\n" +
                       HelpOf("4.2.1", commands)},
          {"feature_extractor",
           OptionHelp({"default_random_seed", "image_list_path", "FeatureExtraction.use_gpu",
                       "FeatureExtraction.num_threads", "FeatureExtraction.max_image_size",
                       "SiftExtraction.first_octave"})},
          {"matches_importer", OptionHelp({"default_random_seed", "FeatureMatching.use_gpu",
                                           "TwoViewGeometry.max_error"})},
          {"mapper", OptionHelp({"default_random_seed", "Mapper.image_list_path",
                                 "Mapper.fix_existing_frames", "Mapper.ba_global_frames_ratio"})},
          {"bundle_adjuster", OptionHelp({"BundleAdjustmentCeres.max_num_iterations",
                                          "BundleAdjustment.refine_rig_from_world"})},
          {"model_aligner", OptionHelp({"ref_is_gps", "alignment_type", "alignment_max_error"})},
          {"global_mapper", OptionHelp({"GlobalMapper.image_list_path"})}};
}

ColmapDialect DialectOf(const Helps& helps) {
  return ColmapDialect([helps](const std::string& command) { return helps.at(command); });
}

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

TEST(ColmapDialect, SpellsAs310Does) {
  ColmapDialect dialect = DialectOf(Version310());
  EXPECT_EQ(dialect.Arguments("matches_importer",
                              {{"SiftMatching.use_gpu", "0"}, {"SiftMatching.max_error", "2"}}),
            (Strings{"--SiftMatching.use_gpu", "0", "--TwoViewGeometry.max_error", "2"}));
  EXPECT_EQ(dialect.Arguments("mapper", {{"Mapper.fix_existing_images", "1"}}),
            (Strings{"--Mapper.fix_existing_images", "1"}));
  EXPECT_TRUE(dialect.HasCommand("pose_prior_mapper"));
  EXPECT_FALSE(dialect.HasCommand("global_mapper"));
}

TEST(ColmapDialect, ASeedAndALimitOfErrorsGoToEveryVersion) {
  for (const Helps& helps : {Version38(), Version310(), Version42()}) {
    ColmapDialect dialect = DialectOf(helps);
    const bool is_38 = dialect.version() == "3.8";
    const std::string seed =
        dialect.version() == "4.2.1" ? "--default_random_seed" : "--random_seed";
    EXPECT_EQ(dialect.Arguments("mapper", {{"random_seed", "7"}}), (Strings{seed, "7"}));
    EXPECT_EQ(dialect.Arguments("model_aligner",
                                {{"robust_alignment", "1"}, {"robust_alignment_max_error", "3"}}),
              is_38 ? (Strings{"--robust_alignment", "1", "--robust_alignment_max_error", "3"})
                    : (Strings{"--alignment_max_error", "3"}));
  }
}

TEST(ColmapDialect, SpellsTheSolverAs4xDoes) {
  ColmapDialect dialect = DialectOf(Version42());
  EXPECT_EQ(dialect.Arguments("bundle_adjuster", {{"BundleAdjustment.max_num_iterations", "9"},
                                                  {"BundleAdjustment.refine_extrinsics", "0"}}),
            (Strings{"--BundleAdjustmentCeres.max_num_iterations", "9",
                     "--BundleAdjustment.refine_rig_from_world", "0"}));
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
