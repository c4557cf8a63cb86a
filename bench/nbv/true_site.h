// A simulated scene that planning sees as it truly is: no photos are rendered, coverage is computed
// from the geometry of the views against the true mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "colmap_ext/coverage/visibility.h"
#include "colmap_ext/scene/coverage_map.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/surface.h"
#include "colmap_ext/scene/view_plan.h"
#include "colmap_ext/session/session_options.h"

namespace colmap_ext {

// Options of a session of that scene, as active_capture has them.
StageOptions OptionsFor(const std::string& scene, const OptionSet& set, const StageOptions& given);

// Coverage of the points of a site, photo by photo, by the paper's rule.
class CoverageCounter {
 public:
  CoverageCounter(const Surface& surface, const RegionOfInterest& region,
                  const CoverageOptions& options);

  void Add(const PosedPhoto& photo);
  const CoverageMap& map() const { return map_; }
  std::size_t NumCovered() const { return map_.Count(CoverageClass::kCovered); }

 private:
  CoverageOptions options_;
  VisibilityEngine engine_;
  CoverageMap map_;
  std::vector<std::vector<Eigen::Vector3d>> good_directions_;  // of each point
};

class TrueSite {
 public:
  // `seed`: of the scene, of the iso-points, and of where the photos really are.
  TrueSite(const std::string& scene, std::uint64_t seed, const StageOptions& options);

  const std::string& scene() const { return scene_; }
  const StageOptions& options() const { return options_; }
  const TriangleMesh& mesh() const { return surface_.mesh; }
  CoverageCounter NewCounter() const { return {surface_, region_, options_.coverage}; }

  // The first flight around the model, photographed.
  std::vector<PosedPhoto> FirstFlight() const;
  // A photo of the view, off by the error of the vehicle's position (Simulation.gps_noise_m).
  PosedPhoto Photograph(const PlannedView& view) const;
  // How many points some pair of views in free space covers, of any strategy: over a dense pool,
  // and those that `photos` cover.
  std::size_t CountCoverable(const std::vector<PosedPhoto>& photos) const;

 private:
  std::string scene_;
  std::uint64_t seed_;
  StageOptions options_;
  Surface surface_;  // without signal
  RegionOfInterest region_;
};

}  // namespace colmap_ext
