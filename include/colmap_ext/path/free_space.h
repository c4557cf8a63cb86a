// What is known about where a vehicle can be.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/scene/photo.h"

namespace colmap_ext {

struct FreeSpaceOptions {
  // Metres, >= 0. All that is higher than the highest point of the surface by this is known free.
  double above_top_m = 5;
  // Metres, >= 0. All that is nearer than this to the convex hull of the flown positions is known
  // free: the pilot vouches for the first flight, and later ones stay in what is known.
  double flown_margin_m = 5;

  std::string Check() const;
};

// Immutable after construction; may be asked from many threads.
class FreeSpace {
 public:
  // `surface`: world. `photos`: their pixels are not needed. `flown`: more places where the vehicle
  // has been (its present one). Photos see the surface by 96 x 54 rays each.
  FreeSpace(const TriangleMesh& surface, const std::vector<PosedPhoto>& photos,
            const std::vector<Eigen::Vector3d>& flown, const FreeSpaceOptions& options);

  // Whether the whole ball is known to be free, by one of:
  // - it lies above the highest reconstructed point by above_top_m;
  // - it lies within flown_margin_m of the convex hull of photo positions and `flown` (the ball
  //   around each is replaced by a polyhedron of 26 corners inside it, so a little less);
  // - some photo has seen past it: each of the photo's rays that meets it goes on to the surface
  //   behind it. Rays that meet no surface prove nothing.
  // Nothing is said about the surface itself: see Clearance.
  bool IsKnownFree(const Eigen::Vector3d& center, double radius_m) const;

  const RayScene& ray_scene() const { return ray_scene_; }

 private:
  struct DepthView {
    Rigid3d cam_from_world;
    PinholeCamera camera;           // of the small image
    std::vector<float> distance_m;  // along each pixel's ray; 0: no surface there
  };

  struct HalfSpace {
    Eigen::Vector3d outwards;  // unit
    double offset_m = 0;       // inside: outwards . point <= offset_m
  };

  static std::vector<HalfSpace> HullAround(const std::vector<Eigen::Vector3d>& positions,
                                           double margin_m);
  static DepthView Look(const RayScene& scene, const PosedPhoto& photo);
  static bool HasSeenPast(const DepthView& view, const Eigen::Vector3d& center, double radius_m);
  bool IsInHull(const Eigen::Vector3d& center, double radius_m) const;

  RayScene ray_scene_;
  double known_above_m_ = 0;     // z of the world
  std::vector<HalfSpace> hull_;  // of what was flown, margin included; empty: nothing was
  std::vector<DepthView> depth_views_;
};

}  // namespace colmap_ext
