#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

TruePose ParseLine(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  TruePose pose;
  double qw = 0, qx = 0, qy = 0, qz = 0;
  Eigen::Vector3d& t = pose.cam_from_world.translation;
  std::string rest;
  if (!(words >> pose.name >> qw >> qx >> qy >> qz >> t.x() >> t.y() >> t.z()) || (words >> rest)) {
    throw Error(where + ": expected 'name qw qx qy qz tx ty tz'");
  }
  const Eigen::Quaterniond rotation(qw, qx, qy, qz);
  if (!(std::abs(rotation.norm() - 1) < 1e-3) || !t.allFinite()) {
    throw Error(where + ": the quaternion of '" + pose.name + "' is not of unit length");
  }
  pose.cam_from_world.rotation = rotation.normalized();
  return pose;
}

}  // namespace

void WriteTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path) {
  std::vector<const TruePose*> sorted;
  for (const TruePose& pose : poses) {
    if (pose.name.empty() || pose.name.find_first_of(" \t\r\n#") != std::string::npos) {
      throw Error(path.string() + ": photo name '" + pose.name +
                  "' must not be empty or hold white space or '#'");
    }
    sorted.push_back(&pose);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const TruePose* a, const TruePose* b) { return a->name < b->name; });
  std::ostringstream text;
  text.precision(17);
  text << "# name qw qx qy qz tx ty tz (cam_from_world, metres)\n";
  for (const TruePose* pose : sorted) {
    const Eigen::Quaterniond& q = pose->cam_from_world.rotation;
    const Eigen::Vector3d& t = pose->cam_from_world.translation;
    text << pose->name << ' ' << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' '
         << t.x() << ' ' << t.y() << ' ' << t.z() << '\n';
  }
  WriteFileAtomically(path, text.str());
}

std::vector<TruePose> ReadTruePoses(const std::filesystem::path& path) {
  std::istringstream lines(ReadFile(path));
  std::vector<TruePose> poses;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line.erase(std::find(line.begin(), line.end(), '#'), line.end());
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    poses.push_back(ParseLine(line, path.string() + ": line " + std::to_string(number)));
  }
  return poses;
}

void UpdateTruePoses(const std::vector<TruePose>& poses, const std::filesystem::path& path) {
  std::map<std::string, TruePose> pose_of_name;
  if (std::filesystem::exists(path)) {
    for (TruePose& pose : ReadTruePoses(path)) pose_of_name[pose.name] = pose;
  }
  for (const TruePose& pose : poses) pose_of_name[pose.name] = pose;
  std::vector<TruePose> all;
  for (auto& [name, pose] : pose_of_name) all.push_back(std::move(pose));
  WriteTruePoses(all, path);
}

}  // namespace colmap_ext
