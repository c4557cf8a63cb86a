#include "colmap_ext/sfm/colmap_dialect.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

// Later spellings of 3.8's options, tried in this order after the original. From 3.9 on, the
// verification of pairs has options of its own; 4.x parted kinds of features, rigs and solvers.
const std::map<std::string, std::vector<std::string>>& LaterSpellings() {
  static const std::map<std::string, std::vector<std::string>> spellings = {
      {"random_seed", {"default_random_seed"}},
      {"image_list_path", {"Mapper.image_list_path"}},
      {"SiftExtraction.use_gpu", {"FeatureExtraction.use_gpu"}},
      {"SiftExtraction.num_threads", {"FeatureExtraction.num_threads"}},
      {"SiftExtraction.max_image_size", {"FeatureExtraction.max_image_size"}},
      {"SiftMatching.use_gpu", {"FeatureMatching.use_gpu"}},
      {"SiftMatching.num_threads", {"FeatureMatching.num_threads"}},
      {"SiftMatching.max_num_matches", {"FeatureMatching.max_num_matches"}},
      {"SiftMatching.guided_matching", {"FeatureMatching.guided_matching"}},
      {"SiftMatching.max_error", {"TwoViewGeometry.max_error"}},
      {"SiftMatching.confidence", {"TwoViewGeometry.confidence"}},
      {"SiftMatching.max_num_trials", {"TwoViewGeometry.max_num_trials"}},
      {"SiftMatching.min_num_inliers", {"TwoViewGeometry.min_num_inliers"}},
      {"SiftMatching.min_inlier_ratio", {"TwoViewGeometry.min_inlier_ratio"}},
      {"SiftMatching.multiple_models", {"TwoViewGeometry.multiple_models"}},
      {"Mapper.fix_existing_images", {"Mapper.fix_existing_frames"}},
      {"Mapper.ba_global_images_ratio", {"Mapper.ba_global_frames_ratio"}},
      {"Mapper.ba_global_images_freq", {"Mapper.ba_global_frames_freq"}},
      {"Mapper.snapshot_images_freq", {"Mapper.snapshot_frames_freq"}},
      {"Mapper.local_ba_min_tri_angle", {"Mapper.ba_local_min_tri_angle"}},
      {"BundleAdjustment.refine_extrinsics", {"BundleAdjustment.refine_rig_from_world"}},
      {"BundleAdjustment.max_num_iterations", {"BundleAdjustmentCeres.max_num_iterations"}},
      {"BundleAdjustment.function_tolerance", {"BundleAdjustmentCeres.function_tolerance"}},
      {"BundleAdjustment.gradient_tolerance", {"BundleAdjustmentCeres.gradient_tolerance"}},
      {"BundleAdjustment.parameter_tolerance", {"BundleAdjustmentCeres.parameter_tolerance"}},
      {"robust_alignment_max_error", {"alignment_max_error"}},
  };
  return spellings;
}

// Options that only tune speed or noise of the log, and those whose meaning later versions took
// into another option (`robust_alignment`: an error limit above 0 says it): left out where a
// version lacks them.
bool OnlyTunes(const std::string& option) {
  static const std::set<std::string> tuning = {
      "random_seed",
      "robust_alignment",
      "Mapper.extract_colors",
      "Mapper.num_threads",
      "Mapper.ba_global_images_ratio",
      "Mapper.ba_global_images_freq",
      "Mapper.ba_global_points_ratio",
      "Mapper.ba_global_max_num_iterations",
      "Mapper.ba_global_max_refinements",
      "Mapper.ba_local_max_num_iterations",
      "Mapper.ba_local_max_refinements",
      "BundleAdjustment.function_tolerance",
      "BundleAdjustment.gradient_tolerance",
      "BundleAdjustment.max_num_iterations",
      "BundleAdjustment.parameter_tolerance",
  };
  return tuning.count(option) > 0;
}

// "… COLMAP 3.8 -- Structure…", "COLMAP 4.2.1 (Commit …)"; logging may come before it.
std::string ParseVersion(const std::string& help) {
  const std::string key = "COLMAP ";
  for (std::size_t at = help.find(key); at != std::string::npos; at = help.find(key, at + 1)) {
    std::string version;
    for (std::size_t i = at + key.size(); i < help.size(); ++i) {
      const char c = help[i];
      if (std::isdigit(static_cast<unsigned char>(c)) == 0 && c != '.') break;
      version += c;
    }
    if (!version.empty() && version.front() != '.') return version;
  }
  return "";
}

// The indented words after "Available commands:".
std::set<std::string> ParseCommands(const std::string& help) {
  std::set<std::string> commands;
  std::istringstream lines(help);
  std::string line;
  bool inside = false;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word, more;
    if (line.find("Available commands") != std::string::npos) {
      inside = true;
    } else if (inside && words >> word && !(words >> more)) {
      commands.insert(word);
    }
  }
  return commands;
}

bool IsNameCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Every "--name" of a help text.
std::set<std::string> ParseOptions(const std::string& help) {
  std::set<std::string> options;
  for (std::size_t at = help.find("--"); at != std::string::npos; at = help.find("--", at + 2)) {
    std::size_t end = at + 2;
    while (end < help.size() && IsNameCharacter(help[end])) ++end;
    if (end > at + 2) options.insert(help.substr(at + 2, end - at - 2));
  }
  return options;
}

}  // namespace

ColmapDialect::ColmapDialect(HelpSource help_source) : help_source_(std::move(help_source)) {
  help_ = help_source_("help");
  version_ = ParseVersion(help_);
  commands_ = ParseCommands(help_);
  if (version_.empty() || commands_.empty()) {
    throw Error(
        "the program given as `colmap` does not answer `colmap help` as COLMAP does; "
        "name COLMAP's program by --colmap_path");
  }
}

bool ColmapDialect::HasCommand(const std::string& command) const {
  return commands_.count(command) > 0;
}

const std::set<std::string>& ColmapDialect::OptionsOf(const std::string& command) {
  if (!HasCommand(command)) {
    throw Error("this colmap " + version_ + " has no command `" + command +
                "`; COLMAP 3.8 or later is needed");
  }
  const auto known = options_of_command_.find(command);
  if (known != options_of_command_.end()) return known->second;
  return options_of_command_[command] = ParseOptions(help_source_(command));
}

std::string ColmapDialect::SpellingOf(const std::string& command, const std::string& option) {
  const std::set<std::string>& available = OptionsOf(command);
  if (available.count(option) > 0) return option;
  const auto later = LaterSpellings().find(option);
  if (later == LaterSpellings().end()) return "";
  for (const std::string& spelling : later->second) {
    if (available.count(spelling) > 0) return spelling;
  }
  return "";
}

bool ColmapDialect::HasOption(const std::string& command, const std::string& option) {
  return HasCommand(command) && !SpellingOf(command, option).empty();
}

std::vector<std::string> ColmapDialect::Arguments(const std::string& command,
                                                  const ColmapOptions& options) {
  OptionsOf(command);  // throws when there is no such command
  std::vector<std::string> arguments;
  for (const auto& [option, value] : options) {
    const std::string spelling = SpellingOf(command, option);
    if (!spelling.empty()) {
      arguments.push_back("--" + spelling);
      arguments.push_back(value);
    } else if (!OnlyTunes(option)) {
      throw Error("`colmap " + command + "` of version " + version_ + " has no option --" + option +
                  "; COLMAP 3.8 to 4.x are supported");
    }
  }
  return arguments;
}

}  // namespace colmap_ext
