#include "colmap_ext/eval/camera_poses.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

// The last seven words of a line are the pose, so that a name may contain spaces.
constexpr std::size_t kPoseWords = 7;

Rigid3d ParsePose(const std::vector<std::string>& words, const std::string& where) {
  double values[kPoseWords];
  for (std::size_t i = 0; i < kPoseWords; ++i) {
    const std::string& word = words[words.size() - kPoseWords + i];
    std::size_t used = 0;
    try {
      values[i] = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != word.size() || !std::isfinite(values[i])) {
      throw Error(where + ": '" + word + "' is not a number");
    }
  }
  const Eigen::Quaterniond rotation(values[0], values[1], values[2], values[3]);
  if (rotation.norm() < 1e-6) throw Error(where + ": the quaternion is zero");
  return {rotation.normalized(), Eigen::Vector3d(values[4], values[5], values[6])};
}

}  // namespace

std::map<std::string, Rigid3d> ReadCameraPoses(const std::filesystem::path& path) {
  std::istringstream stream(ReadFile(path));
  std::map<std::string, Rigid3d> pose_of_name;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream in_line(line);
    std::vector<std::string> words;
    for (std::string word; in_line >> word;) words.push_back(word);
    if (words.empty() || words[0][0] == '#') continue;
    const std::string where = path.string() + ":" + std::to_string(number);
    if (words.size() <= kPoseWords) {
      throw Error(where + ": expected 'name qw qx qy qz tx ty tz'");
    }
    std::string name = words[0];
    for (std::size_t i = 1; i + kPoseWords < words.size(); ++i) name += " " + words[i];
    if (!pose_of_name.emplace(name, ParsePose(words, where)).second) {
      throw Error(where + ": the photo '" + name + "' is given twice");
    }
  }
  return pose_of_name;
}

}  // namespace colmap_ext
