#include "mapping_stage.h"

#include <algorithm>
#include <vector>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "gauge.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// A third of the mapper's default time for poses that differ by less than 4e-4 of the scene. One
// thread: several would add up residuals in another order on every run.
ColmapOptions FastOptions(const MappingPaths& paths, bool refine_intrinsics) {
  const std::string refine = refine_intrinsics ? "1" : "0";
  return {{"database_path", paths.database.string()},
          {"image_path", paths.images.string()},
          {"Mapper.num_threads", "1"},
          {"Mapper.extract_colors", "0"},
          {"Mapper.ba_refine_focal_length", refine},
          {"Mapper.ba_refine_extra_params", refine},
          {"Mapper.ba_global_images_ratio", "1.4"},
          {"Mapper.ba_global_points_ratio", "1.4"},
          {"Mapper.ba_global_max_num_iterations", "20"},
          {"Mapper.ba_global_max_refinements", "2"},
          {"Mapper.ba_local_max_num_iterations", "15"},
          {"Mapper.ba_local_max_refinements", "1"}};
}

fs::path FreshFolder(const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

// The model with most photos in `folder` and the folders in it; the first one in name order of
// several. Empty when there is none.
Reconstruction ReadLargestModel(const fs::path& folder) {
  std::vector<fs::path> candidates = {folder};
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory()) candidates.push_back(entry.path());
  }
  std::sort(candidates.begin(), candidates.end());
  Reconstruction largest;
  for (const fs::path& candidate : candidates) {
    if (!fs::exists(candidate / "images.bin")) continue;
    Reconstruction model = ReadReconstruction(candidate);
    if (model.images.size() > largest.images.size()) largest = std::move(model);
  }
  return largest;
}

Reconstruction RunMapper(const MappingPaths& paths, bool refine_intrinsics, bool multiple_models,
                         ColmapProgram* colmap, const JobControl& job) {
  const fs::path output = FreshFolder(paths.work / "mapper_output");
  ColmapOptions options = FastOptions(paths, refine_intrinsics);
  options.emplace_back("output_path", output.string());
  options.emplace_back("Mapper.multiple_models", multiple_models ? "1" : "0");
  colmap->TryRun("mapper", options, paths.log, job);  // fails when the matches give no model
  Reconstruction model = ReadLargestModel(output);
  fs::remove_all(output);
  return model;
}

}  // namespace

Reconstruction MapFromScratch(const MappingPaths& paths, bool refine_intrinsics,
                              ColmapProgram* colmap, const JobControl& job) {
  Reconstruction model = RunMapper(paths, refine_intrinsics, false, colmap, job);
  // A few photos that start in a corner may grow no further: let the mapper try other starts.
  constexpr std::size_t kTinyModel = 10;
  if (model.images.empty() || model.images.size() >= kTinyModel) return model;
  Reconstruction other = RunMapper(paths, refine_intrinsics, true, colmap, job);
  return other.images.size() > model.images.size() ? other : model;
}

Reconstruction ContinueModel(const MappingPaths& paths, const Reconstruction& model,
                             bool adjust_all, ColmapProgram* colmap, const JobControl& job) {
  const fs::path input = FreshFolder(paths.work / "mapper_input");
  const fs::path output = FreshFolder(paths.work / "mapper_output");
  WriteReconstructionBinary(model, input);
  ColmapOptions options = FastOptions(paths, false);
  options.emplace_back("input_path", input.string());
  options.emplace_back("output_path", output.string());
  options.emplace_back("Mapper.fix_existing_images", adjust_all ? "0" : "1");
  colmap->Run("mapper", options, paths.log, job);
  Reconstruction continued = ReadLargestModel(output);
  if (continued.images.size() < model.images.size()) {
    throw Error("`colmap mapper` lost photos of the model that it was to continue (" +
                std::to_string(continued.images.size()) + " of " +
                std::to_string(model.images.size()) + " left); full output: " + paths.log.string());
  }
  // Several versions normalise the model, fixed poses or not: bring it back.
  TransformReconstruction(ReferenceFromMoved(model, continued), &continued);
  fs::remove_all(input);
  fs::remove_all(output);
  return continued;
}

}  // namespace colmap_ext
