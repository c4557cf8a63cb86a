#include "colmap_ext/scene/true_poses.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/shortest_digits.h"
#include "scene/text_numbers.h"

namespace colmap_ext {
namespace {

// The last seven words of a line are the pose, so that a name may hold spaces.
constexpr std::size_t kPoseWords = 7;

TruePose ParseLine(std::string_view line, const std::string& where) {
  const std::vector<std::string_view> words = SplitWords(line);
  if (words.size() <= kPoseWords) throw Error(where + "expected 'name qw qx qy qz tx ty tz'");
  TruePose pose;
  const std::size_t num_name_words = words.size() - kPoseWords;
  for (std::size_t i = 0; i < num_name_words; ++i) {
    pose.name += (i == 0 ? "" : " ") + std::string(words[i]);
  }
  std::array<double, kPoseWords> values;
  for (std::size_t i = 0; i < kPoseWords; ++i) {
    const std::string_view word = words[num_name_words + i];
    const auto value = ParseNumber(word);
    if (!value || !std::isfinite(*value)) {
      throw Error(where + "'" + std::string(word.substr(0, 40)) +
                  "' is not a number; expected 'name qw qx qy qz tx ty tz'");
    }
    values[i] = *value;
  }
  const Eigen::Quaterniond rotation(values[0], values[1], values[2], values[3]);
  if (!(std::abs(rotation.norm() - 1) < 0.01)) {
    throw Error(where + "the quaternion of '" + pose.name + "' is not of unit length");
  }
  pose.cam_from_world = {rotation.normalized(), Eigen::Vector3d(values[4], values[5], values[6])};
  return pose;
}

// Read by ParseLine as it is.
bool IsWritableName(const std::string& name) {
  return !name.empty() && name.find_first_of("\t\r\n#") == std::string::npos &&
         name.find("  ") == std::string::npos && name.front() != ' ' && name.back() != ' ';
}

}  // namespace

std::vector<TruePose> ReadTruePoses(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  std::map<std::string, Rigid3d> pose_of_name;
  std::size_t offset = 0;
  for (std::size_t number = 1;; ++number) {
    const auto line = NextLine(text, &offset);
    if (!line) break;
    const std::string_view content = line->substr(0, line->find('#'));
    if (content.find_first_not_of(" \t") == std::string_view::npos) continue;
    const std::string where = path.string() + ": line " + std::to_string(number) + ": ";
    TruePose pose = ParseLine(content, where);
    if (!pose_of_name.emplace(pose.name, pose.cam_from_world).second) {
      throw Error(where + "photo " + pose.name + " is named twice");
    }
  }
  std::vector<TruePose> poses;
  for (const auto& [name, pose] : pose_of_name) poses.push_back({name, pose});
  return poses;
}

void WriteTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path) {
  std::vector<const TruePose*> sorted;
  for (const TruePose& pose : poses) {
    if (!IsWritableName(pose.name)) {
      throw Error(path.string() + ": photo name '" + pose.name +
                  "' must not be empty or hold tabs, line ends, '#' or spaces side by side");
    }
    sorted.push_back(&pose);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const TruePose* a, const TruePose* b) { return a->name < b->name; });
  std::string text = "# name qw qx qy qz tx ty tz (cam_from_world, metres)\n";
  for (const TruePose* pose : sorted) {
    const Eigen::Quaterniond& q = pose->cam_from_world.rotation;
    const Eigen::Vector3d& t = pose->cam_from_world.translation;
    text += pose->name;
    for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      text += ' ' + ShortestDigits(value);
    }
    text += '\n';
  }
  WriteFileAtomically(path, text);
}

void UpdateTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path) {
  std::map<std::string, Rigid3d> pose_of_name;
  if (std::filesystem::exists(path)) pose_of_name = PoseOfPhoto(ReadTruePoses(path));
  for (const TruePose& pose : poses) pose_of_name[pose.name] = pose.cam_from_world;
  std::vector<TruePose> all;
  for (const auto& [name, pose] : pose_of_name) all.push_back({name, pose});
  WriteTruePoses(all, path);
}

std::map<std::string, Rigid3d> PoseOfPhoto(const std::vector<TruePose>& poses) {
  std::map<std::string, Rigid3d> pose_of_name;
  for (const TruePose& pose : poses) pose_of_name[pose.name] = pose.cam_from_world;
  return pose_of_name;
}

}  // namespace colmap_ext
