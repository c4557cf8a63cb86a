// Random sites for the safety campaign: what is really there, what a first flight saw of it, and
// exact distances and lines of sight that share no code with the planner.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_plan.h"

namespace colmap_ext {

// A piece of the true surface: an axis-aligned rectangle, flat along one axis. World, metres.
struct Patch {
  Eigen::AlignedBox3d box;
  bool faces_up = true;  // outwards is along its axis, else against it
};

struct RandomSite {
  std::vector<Eigen::AlignedBox3d> solids;  // all that is there: the ground is the first
  std::vector<Patch> observed;              // what some photo saw of what was reconstructed
  // Of the first flight, a rectangle at one height, then of planned flights, anywhere in free air.
  std::vector<PosedPhoto> photos;
  std::size_t num_first_photos = 0;
  Eigen::AlignedBox3d flown;  // that rectangle: flat
  std::string start_kind;     // "free", "near", "inside"
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  std::vector<PlannedView> views;
};

// Ground of 60 m, buildings, walls, overhangs, poles of 3 … 30 cm, wires of 3 cm. Some poles and
// wires are there but not reconstructed. Same seed, same site.
RandomSite MakeRandomSite(std::uint64_t seed);

// Two triangles a patch.
TriangleMesh ObservedSurface(const RandomSite& site);

// Distance to the nearest of `patches`, or `max_m`.
double DistanceToPatches(const std::vector<Patch>& patches, const Eigen::Vector3d& point,
                         double max_m);
// Those that are nearer than `max_m` to some point of the box.
std::vector<Patch> PatchesNear(const std::vector<Patch>& patches, const Eigen::AlignedBox3d& box,
                               double max_m);

// How a line of sight from a photo to a point meets the observed surface.
enum class Sight {
  kNone,     // out of the picture
  kBlocked,  // surface lies before the point
  kOpen,     // nothing before it, but nothing behind it either
  kThrough,  // nothing before it, surface behind it: the point is seen to be free
};
Sight SightOf(const PosedPhoto& photo, const std::vector<Patch>& patches,
              const Eigen::Vector3d& point);

}  // namespace colmap_ext
