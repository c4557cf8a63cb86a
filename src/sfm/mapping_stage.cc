#include "mapping_stage.h"

#include <algorithm>
#include <string>
#include <utility>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "gauge.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// One thread: several would add up residuals in another order on every run.
ColmapOptions CommonOptions(const MappingPaths& paths, bool refine_intrinsics) {
  const std::string refine = refine_intrinsics ? "1" : "0";
  return {{"database_path", paths.database.string()},
          {"image_path", paths.images.string()},
          {"Mapper.num_threads", "1"},
          {"Mapper.extract_colors", "0"},
          {"Mapper.ba_refine_focal_length", refine},
          {"Mapper.ba_refine_extra_params", refine},
          {"Mapper.ba_global_images_ratio", "1.4"},
          {"Mapper.ba_global_points_ratio", "1.4"}};
}

// An update is adjusted by ourselves afterwards. The first model gets COLMAP's own care instead:
// its repeated triangulation finds a few percent more points.
void AddFastOptions(ColmapOptions* options) {
  for (const auto& [name, value] : ColmapOptions{{"Mapper.ba_global_max_num_iterations", "20"},
                                                 {"Mapper.ba_global_max_refinements", "2"},
                                                 {"Mapper.ba_local_max_num_iterations", "15"},
                                                 {"Mapper.ba_local_max_refinements", "1"}}) {
    options->emplace_back(name, value);
  }
}

fs::path FreshFolder(const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

// The models in `folder` and the folders in it, in the order of their names (as numbers).
std::vector<Reconstruction> ReadModels(const fs::path& folder) {
  std::vector<fs::path> candidates;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory()) candidates.push_back(entry.path());
  }
  std::sort(candidates.begin(), candidates.end(), [](const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    return std::pair(x.size(), x) < std::pair(y.size(), y);
  });
  candidates.insert(candidates.begin(), folder);
  std::vector<Reconstruction> models;
  for (const fs::path& candidate : candidates) {
    if (fs::exists(candidate / "images.bin")) models.push_back(ReadReconstruction(candidate));
  }
  return models;
}

// The model with most photos, the first one of several; empty when there is none.
Reconstruction Largest(std::vector<Reconstruction> models) {
  Reconstruction largest;
  for (Reconstruction& model : models) {
    if (model.images.size() > largest.images.size()) largest = std::move(model);
  }
  return largest;
}

std::vector<Reconstruction> RunMapper(const MappingPaths& paths, bool refine_intrinsics,
                                      bool multiple_models, ColmapProgram* colmap,
                                      const JobControl& job) {
  const fs::path output = FreshFolder(paths.work / "mapper_output");
  ColmapOptions options = CommonOptions(paths, refine_intrinsics);
  options.emplace_back("output_path", output.string());
  options.emplace_back("Mapper.multiple_models", multiple_models ? "1" : "0");
  colmap->TryRun("mapper", options, paths.log, job);  // fails when the matches give no model
  std::vector<Reconstruction> models = ReadModels(output);
  fs::remove_all(output);
  return models;
}

}  // namespace

Reconstruction MapFromScratch(const MappingPaths& paths, bool refine_intrinsics,
                              ColmapProgram* colmap, const JobControl& job) {
  Reconstruction model = Largest(RunMapper(paths, refine_intrinsics, false, colmap, job));
  // A few photos that start in a corner may grow no further: let the mapper try other starts.
  constexpr std::size_t kTinyModel = 10;
  if (model.images.empty() || model.images.size() >= kTinyModel) return model;
  Reconstruction other = Largest(RunMapper(paths, refine_intrinsics, true, colmap, job));
  return other.images.size() > model.images.size() ? other : model;
}

std::vector<Reconstruction> MapAll(const MappingPaths& paths, ColmapProgram* colmap,
                                   const JobControl& job) {
  return RunMapper(paths, false, true, colmap, job);
}

Reconstruction ContinueModel(const MappingPaths& paths, const Reconstruction& model,
                             ColmapProgram* colmap, const JobControl& job) {
  const fs::path input = FreshFolder(paths.work / "mapper_input");
  const fs::path output = FreshFolder(paths.work / "mapper_output");
  WriteReconstructionBinary(model, input);
  ColmapOptions options = CommonOptions(paths, false);
  AddFastOptions(&options);
  options.emplace_back("input_path", input.string());
  options.emplace_back("output_path", output.string());
  options.emplace_back("Mapper.fix_existing_images", "1");
  colmap->Run("mapper", options, paths.log, job);
  Reconstruction continued = Largest(ReadModels(output));
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
