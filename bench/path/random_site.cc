#include "random_site.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace colmap_ext {
namespace {

constexpr double kHalfGround_m = 30;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class SiteMaker {
 public:
  explicit SiteMaker(std::uint64_t seed) : random_(seed) {}

  RandomSite Make() {
    AddSolid({-kHalfGround_m, -kHalfGround_m, -1}, {kHalfGround_m, kHalfGround_m, 0}, true);
    AddBuildings();
    AddWalls();
    AddPolesAndWires();
    Fly();
    Observe();
    ChooseStart();
    ChooseViews();
    FlyPlanned();
    return std::move(site_);
  }

 private:
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int Count(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool Chance(double probability) { return Between(0, 1) < probability; }

  void AddSolid(const Eigen::Vector3d& low, const Eigen::Vector3d& high, bool is_reconstructed) {
    site_.solids.emplace_back(low, high);
    is_reconstructed_.push_back(is_reconstructed);
  }

  void AddBuildings() {
    const int count = Count(1, 4);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d low(Between(-16, 10), Between(-16, 10), 0);
      const Eigen::Vector3d size(Between(3, 10), Between(3, 10), Between(3, 12));
      AddSolid(low, low + size, true);
      if (!Chance(0.5)) continue;
      // An overhang: a roof that sticks out, and stands on a post where it ends.
      const double out_m = Between(2, 8);
      const Eigen::Vector3d roof_low(low.x() + size.x(), low.y(), size.z() - 0.5);
      AddSolid(roof_low, roof_low + Eigen::Vector3d(out_m, size.y(), 0.5), true);
      const Eigen::Vector3d post(roof_low.x() + out_m - 0.3, low.y(), 0);
      AddSolid(post, post + Eigen::Vector3d(0.3, 0.3, size.z() - 0.5), true);
    }
  }

  void AddWalls() {
    const int count = Count(0, 3);
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3d low(Between(-18, 14), Between(-18, 14), 0);
      Eigen::Vector3d size(0.2, Between(4, 16), Between(2, 9));
      if (Chance(0.5)) std::swap(size.x(), size.y());
      AddSolid(low, low + size, true);
    }
  }

  // Wires of 3 cm run along an axis between the tops of two poles.
  void AddPolesAndWires() {
    const int count = Count(1, 4);
    for (int i = 0; i < count; ++i) {
      const double width = Between(0.03, 0.3);
      const double height = Between(4, 14);
      const double length = Between(6, 24);
      const Eigen::Vector3d low(Between(-18, 0), Between(-18, 0), 0);
      Eigen::Vector3d along(length, 0, 0);
      if (Chance(0.5)) along = {0, length, 0};
      const Eigen::Vector3d pole(width, width, height);
      const bool is_reconstructed = Chance(0.7);
      AddSolid(low, low + pole, is_reconstructed);
      AddSolid(low + along, low + along + pole, is_reconstructed);
      const Eigen::Vector3d wire = low + Eigen::Vector3d(0, 0, height - 0.1);
      AddSolid(wire, wire + along + Eigen::Vector3d::Constant(0.03), Chance(0.5));
    }
  }

  // Photos look inward and down from a rectangle outside of everything.
  void Fly() {
    const double half = Between(20, 26);
    const double height = Between(10, 18);
    site_.flown = {Eigen::Vector3d(-half, -half, height), Eigen::Vector3d(half, half, height)};
    const int a_side = Count(5, 9);
    const double pitch_deg = Between(-45, -20);
    for (int side = 0; side < 4; ++side) {
      for (int i = 0; i < a_side; ++i) {
        const double along = -half + 2 * half * i / a_side;
        const double turn = DegToRad(90.0 * side);
        const Eigen::Vector2d place(std::cos(turn) * along + std::sin(turn) * half,
                                    std::sin(turn) * along - std::cos(turn) * half);
        PosedPhoto photo;
        photo.camera = {640, 368, 420, 420, 320, 184};
        const double yaw = -turn + DegToRad(Between(-10, 10));
        photo.cam_from_world =
            CamFromWorld({place.x(), place.y(), height}, {yaw, DegToRad(pitch_deg)});
        photo.name = "first" + std::to_string(site_.photos.size());
        site_.photos.push_back(photo);
      }
    }
    site_.num_first_photos = site_.photos.size();
  }

  // Photos of earlier planned flights: nobody vouches for what is around them.
  void FlyPlanned() {
    const int count = Count(0, 12);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d place(Between(-40, 40), Between(-40, 40), Between(2, 22));
      const double yaw = std::atan2(-place.x(), -place.y()) + DegToRad(Between(-40, 40));
      const double pitch = DegToRad(Between(-60, 10));
      const bool is_free = std::none_of(site_.solids.begin(), site_.solids.end(),
                                        [&](const Eigen::AlignedBox3d& solid) {
                                          return solid.squaredExteriorDistance(place) < 1;
                                        });
      if (!is_free) continue;
      PosedPhoto photo = site_.photos.front();
      photo.name = "planned" + std::to_string(i);
      photo.cam_from_world = CamFromWorld(place, {yaw, pitch});
      site_.photos.push_back(photo);
    }
  }

  // Faces in pieces; those that a photo sees (their middle, past all that is there) are observed.
  void Observe() {
    for (std::size_t i = 0; i < site_.solids.size(); ++i) {
      if (!is_reconstructed_[i]) continue;
      for (int axis = 0; axis < 3; ++axis) {
        for (const bool high : {false, true}) ObserveFace(site_.solids[i], axis, high);
      }
    }
  }

  void ObserveFace(const Eigen::AlignedBox3d& solid, int axis, bool high) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double piece_m = solid.sizes().maxCoeff() > 40 ? 3.0 : 1.5;
    const int count_u = std::max(1, static_cast<int>(std::ceil(solid.sizes()[u] / piece_m)));
    const int count_v = std::max(1, static_cast<int>(std::ceil(solid.sizes()[v] / piece_m)));
    for (int i = 0; i < count_u; ++i) {
      for (int j = 0; j < count_v; ++j) {
        Eigen::AlignedBox3d box = solid;
        box.min()[u] = solid.min()[u] + solid.sizes()[u] * i / count_u;
        box.max()[u] = solid.min()[u] + solid.sizes()[u] * (i + 1) / count_u;
        box.min()[v] = solid.min()[v] + solid.sizes()[v] * j / count_v;
        box.max()[v] = solid.min()[v] + solid.sizes()[v] * (j + 1) / count_v;
        box.min()[axis] = box.max()[axis] = high ? solid.max()[axis] : solid.min()[axis];
        Eigen::Vector3d outwards = Eigen::Vector3d::Zero();
        outwards[axis] = high ? 1e-6 : -1e-6;
        if (IsSeen(box.center() + outwards, outwards)) site_.observed.push_back({box, high});
      }
    }
  }

  bool IsSeen(const Eigen::Vector3d& point, const Eigen::Vector3d& outwards) const {
    return std::any_of(site_.photos.begin(), site_.photos.end(), [&](const PosedPhoto& photo) {
      const Eigen::Vector3d center = CameraCenter(photo.cam_from_world);
      const Eigen::Vector3d in_cam = photo.cam_from_world * point;
      if (in_cam.z() <= 0 || outwards.dot(center - point) <= 0) return false;
      const Eigen::Vector2d pixel = photo.camera.Project(in_cam);
      if (pixel.minCoeff() < 0 || pixel.x() > photo.camera.width ||
          pixel.y() > photo.camera.height) {
        return false;
      }
      return std::none_of(
          site_.solids.begin(), site_.solids.end(),
          [&](const Eigen::AlignedBox3d& solid) { return Cuts(solid, center, point); });
    });
  }

  // Whether the segment passes through the box (slabs).
  static bool Cuts(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& a,
                   const Eigen::Vector3d& b) {
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double step = b[axis] - a[axis];
      if (step == 0) {
        if (a[axis] < box.min()[axis] || a[axis] > box.max()[axis]) return false;
        continue;
      }
      const double t1 = (box.min()[axis] - a[axis]) / step;
      const double t2 = (box.max()[axis] - a[axis]) / step;
      enter = std::max(enter, std::min(t1, t2));
      leave = std::min(leave, std::max(t1, t2));
    }
    return enter < leave;
  }

  void ChooseStart() {
    site_.start = CameraCenter(site_.photos.back().cam_from_world);
    site_.start_kind = "free";
    if (Chance(0.05)) {
      site_.start = site_.solids[1].center();
      site_.start_kind = "inside";
    }
  }

  void ChooseViews() {
    const int count = Count(1, 8);
    for (int i = 0; i < count; ++i) {
      PlannedView view;
      view.id = i;
      view.position << Between(-22, 22), Between(-22, 22), Between(1, 20);
      view.direction.yaw_rad = Between(-3, 3);
      // Some in the middle of what is solid, where no way can lead.
      if (Chance(0.1)) view.position = site_.solids[1].center();
      site_.views.push_back(view);
    }
  }

  std::mt19937_64 random_;
  RandomSite site_;
  std::vector<bool> is_reconstructed_;
};

// Where the segment a + t (b - a) meets the patch; infinity: nowhere.
double MeetsAt(const Patch& patch, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  int axis = 0;
  (patch.box.max() - patch.box.min()).minCoeff(&axis);
  const double step = b[axis] - a[axis];
  if (step == 0) return kInfinity;
  const double t = (patch.box.min()[axis] - a[axis]) / step;
  if (t <= 0) return kInfinity;
  const Eigen::Vector3d point = a + t * (b - a);
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
    if (point[other] < patch.box.min()[other] || point[other] > patch.box.max()[other]) {
      return kInfinity;
    }
  }
  return t;
}

}  // namespace

RandomSite MakeRandomSite(std::uint64_t seed) { return SiteMaker(seed).Make(); }

TriangleMesh ObservedSurface(const RandomSite& site) {
  TriangleMesh mesh;
  for (const Patch& patch : site.observed) {
    int axis = 0;
    (patch.box.max() - patch.box.min()).minCoeff(&axis);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int first = static_cast<int>(mesh.vertices.size());
    for (int corner = 0; corner < 4; ++corner) {
      Eigen::Vector3d vertex = patch.box.min();
      if (corner == 1 || corner == 2) vertex[u] = patch.box.max()[u];
      if (corner >= 2) vertex[v] = patch.box.max()[v];
      mesh.vertices.push_back(vertex);
    }
    const int second = patch.faces_up ? 1 : 3, fourth = 4 - second;
    mesh.faces.emplace_back(first, first + second, first + 2);
    mesh.faces.emplace_back(first, first + 2, first + fourth);
  }
  return mesh;
}

double DistanceToPatches(const std::vector<Patch>& patches, const Eigen::Vector3d& point,
                         double max_m) {
  double least = max_m * max_m;
  for (const Patch& patch : patches) {
    least = std::min(least, patch.box.squaredExteriorDistance(point));
  }
  return std::sqrt(least);
}

std::vector<Patch> PatchesNear(const std::vector<Patch>& patches, const Eigen::AlignedBox3d& box,
                               double max_m) {
  std::vector<Patch> near;
  for (const Patch& patch : patches) {
    if (patch.box.squaredExteriorDistance(box) <= max_m * max_m) near.push_back(patch);
  }
  return near;
}

Sight SightOf(const PosedPhoto& photo, const std::vector<Patch>& patches,
              const Eigen::Vector3d& point) {
  const Eigen::Vector3d in_cam = photo.cam_from_world * point;
  if (in_cam.z() <= 0) return Sight::kNone;
  const Eigen::Vector2d pixel = photo.camera.Project(in_cam);
  if (pixel.minCoeff() < 0 || pixel.x() > photo.camera.width || pixel.y() > photo.camera.height) {
    return Sight::kNone;
  }
  const Eigen::Vector3d center = CameraCenter(photo.cam_from_world);
  bool has_behind = false;
  for (const Patch& patch : patches) {
    const double at = MeetsAt(patch, center, point);
    if (at <= 1) return Sight::kBlocked;
    has_behind = has_behind || at < kInfinity;
  }
  return has_behind ? Sight::kThrough : Sight::kOpen;
}

}  // namespace colmap_ext
