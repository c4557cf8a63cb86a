// What is known about where a vehicle can be.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"

namespace colmap_ext {

// The pilot vouches for `flown_margin_m`, `above_top_m` and `zones`; what photos have looked
// through, and where the vehicle was, is measured.
struct FreeSpaceOptions {
  // Metres, >= 0. All that is higher than the highest point of the surface by this is known free.
  // Negative: nothing is known about heights.
  double above_top_m = 5;
  // Metres, >= 0. All that is nearer than this to the convex hull of the vouched places is known
  // free. 0: nothing is known from them.
  double flown_margin_m = 5;
  // Metres, >= 0. The same around each single visited place, without any hull.
  double visited_margin_m = 1;
  // World, metres: known free.
  std::vector<FlightZone> zones;
  // Rays free what lies before confident surface: where the points that support it (its
  // sample_spacing_m) are no further apart than this, metres; 0: all of the surface is confident.
  double confident_spacing_m = 0;

  std::string Check() const;
};

// Where the vehicle has been. World, metres.
struct FlownPlaces {
  // Of flights that a person planned and vouches for as a whole.
  std::vector<Eigen::Vector3d> vouched;
  // Of all others, such as flights planned here: what lies between and around them proves nothing.
  std::vector<Eigen::Vector3d> visited;
};

// Parses a list of volumes that are known free, separated by ';': "flown" (the hull of the vouched
// places), "above_top", "none" (only what was seen), boxes "x,y,z,x,y,z" (two opposite corners;
// world, metres) and files of zones (ReadFlightLimits; their names end in "json"). "flown" and
// "above_top" are taken out of `options` where they are not named, boxes are added; files are
// checked by name only, and returned. Throws UsageError naming what is wrong.
std::vector<std::filesystem::path> SetFreeVolume(const std::string& text,
                                                 FreeSpaceOptions* options);

// Immutable after construction; may be asked from many threads.
class FreeSpace {
 public:
  // `surface`: world; without sample_spacing_m all of it is confident. `photos`: their pixels are
  // not needed; each sees the surface by an image of 96 x 54 pixels. That it was flown is only told
  // by `flown`.
  FreeSpace(const Surface& surface, const std::vector<PosedPhoto>& photos, const FlownPlaces& flown,
            const FreeSpaceOptions& options);
  ~FreeSpace();
  FreeSpace(FreeSpace&&) noexcept;
  FreeSpace& operator=(FreeSpace&&) noexcept;

  // Whether the whole ball is known to be free, by one of:
  // - it lies above the highest reconstructed point by above_top_m, or in one of `zones`;
  // - it lies within flown_margin_m of the convex hull of the vouched places (the ball around each
  //   is replaced by a polyhedron of 26 corners inside it, so a little less);
  // - it lies within visited_margin_m of a visited place;
  // - some photo has seen past it: in all of the photo's pixels that the ball touches, the nearest
  //   surface is behind the ball (a pixel counts with all of its rays, so that no thin pole is
  //   missed), with confident surface at their corners. Rays that meet no surface prove nothing.
  // Nothing is said about the surface itself: see Clearance.
  bool IsKnownFree(const Eigen::Vector3d& center, double radius_m) const;

  // Whether the point is behind the surface: of the rays to all sides most that meet it meet a back
  // face (faces are counter-clockwise seen from outside).
  bool IsInsideSurface(const Eigen::Vector3d& point) const;

  const RayScene& ray_scene() const;
  // z of the highest point of the surface; -infinity without one.
  double SurfaceTop() const;
  // Of the surface and of where the vehicle has been; empty without both.
  const Eigen::AlignedBox3d& Bounds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
