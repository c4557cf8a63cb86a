#include "colmap_ext/sim/scene_views.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

bool LeavesFolder(const std::filesystem::path& name) {
  return name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
}

NamedView ParseView(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  NamedView named;
  double yaw_deg = 0, pitch_deg = 0;
  std::string rest;
  Eigen::Vector3d& p = named.view.position;
  if (!(words >> named.name >> p.x() >> p.y() >> p.z() >> yaw_deg >> pitch_deg) ||
      (words >> rest)) {
    throw Error(where + ": expected 'name x y z yaw_deg pitch_deg'");
  }
  if (!(std::abs(pitch_deg) <= 90)) throw Error(where + ": pitch must be in [-90, 90] degrees");
  if (!p.allFinite() || !std::isfinite(yaw_deg)) {
    throw Error(where + ": position and yaw must be finite numbers");
  }
  if (LeavesFolder(named.name)) {
    throw Error(where + ": name '" + named.name + "' must be relative and stay in its folder");
  }
  named.view.direction = {DegToRad(yaw_deg), DegToRad(pitch_deg)};
  if (!std::filesystem::path(named.name).has_extension()) named.name += ".jpg";
  return named;
}

PlannedView LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d d = to - from;
  PlannedView view;
  view.position = from;
  view.direction.yaw_rad = std::atan2(d.x(), d.y());
  view.direction.pitch_rad = std::atan2(d.z(), d.head<2>().norm());
  return view;
}

}  // namespace

std::vector<NamedView> ReadPoseList(const std::filesystem::path& path) {
  RequireFile(path, "pose list");
  std::istringstream lines(ReadFile(path));
  std::vector<NamedView> views;
  std::set<std::string> names;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line.erase(std::find(line.begin(), line.end(), '#'), line.end());
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = path.string() + ": line " + std::to_string(number);
    NamedView named = ParseView(line, where);
    named.view.id = static_cast<int>(views.size());
    if (!names.insert(named.name).second) {
      throw Error(where + ": name '" + named.name + "' comes twice");
    }
    views.push_back(std::move(named));
  }
  if (views.empty()) throw Error(path.string() + ": holds no view");
  return views;
}

std::vector<NamedView> OverviewOf(const TexturedScene& scene) {
  const BoundingBox model = BoundsOf(scene.Truth().model);
  BoundingBox allowed = BoundsOf(scene.mesh);
  const Eigen::Vector3d margin = 0.05 * allowed.sizes();
  allowed = BoundingBox(allowed.min() + margin, allowed.max() - margin);
  const double extent = model.sizes().maxCoeff();
  // Inside the ground's outline, at whatever height.
  const auto place = [&](double yaw_deg, double distance, double height) {
    const double yaw = DegToRad(yaw_deg);
    Eigen::Vector3d p =
        model.center() - distance * Eigen::Vector3d(std::sin(yaw), std::cos(yaw), 0);
    p.head<2>() = p.head<2>().cwiseMax(allowed.min().head<2>()).cwiseMin(allowed.max().head<2>());
    p.z() = model.min().z() + height;
    return p;
  };
  const double tall = model.sizes().z();
  std::vector<PlannedView> views;
  for (int i = 0; i < 6; ++i) {
    views.push_back(LookAt(place(35 + 60 * i, 1.3 * extent, 0.75 * tall + 0.2 * extent),
                           model.center() - Eigen::Vector3d(0, 0, 0.08 * tall)));
  }
  views.push_back(LookAt(place(20, 1.15 * extent, 0.12 * tall), model.center()));
  views.push_back(LookAt(place(60, 0.8 * extent, 0.7 * tall), model.center()));
  std::vector<NamedView> named;
  for (PlannedView& view : views) {
    view.id = static_cast<int>(named.size());
    named.push_back({"overview_" + std::to_string(view.id) + ".jpg", view});
  }
  return named;
}

}  // namespace colmap_ext
