// COLMAP by itself, as its tutorial and manual say: what sparse_updater is compared with.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/geom/camera.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {

using StepCosts = std::map<std::string, StageCost>;
StageCost Total(const StepCosts& costs);

// A project of plain COLMAP in one folder: database.db and model folders.
class PlainColmap {
 public:
  PlainColmap(std::filesystem::path folder, Camera camera, const SparseUpdateOptions& sift,
              ColmapProgram* colmap);

  // feature_extractor, spatial_matcher with so many neighbours (0: COLMAP's default) and mapper.
  StepCosts FromScratch(const std::filesystem::path& images, int neighbors);
  // feature_extractor, matches_importer of the pairs (names) and mapper --input_path.
  StepCosts Update(const std::filesystem::path& images, const std::vector<std::string>& new_photos,
                   const std::vector<std::pair<std::string, std::string>>& pairs);
  const Reconstruction& model() const { return model_; }

 private:
  StageCost Extract(const std::filesystem::path& images, const std::vector<std::string>& photos);
  StageCost Map(const std::filesystem::path& images, const std::filesystem::path& input);
  StageCost Timed(const std::string& command, const ColmapOptions& options);

  std::filesystem::path folder_;
  Camera camera_;
  SparseUpdateOptions sift_;
  ColmapProgram* colmap_;
  Reconstruction model_;
  int num_models_ = 0;
};

}  // namespace colmap_ext
