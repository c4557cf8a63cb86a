#include "rivals.h"

#include <cstdio>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

std::string ParamsText(const Camera& camera) {
  std::string text;
  for (const double param : camera.params) {
    char number[32];
    std::snprintf(number, sizeof(number), "%.17g", param);
    text += (text.empty() ? "" : ",") + std::string(number);
  }
  return text;
}

// The model with most photos among the numbered folders.
Reconstruction LargestModel(const fs::path& folder) {
  Reconstruction largest;
  for (const fs::path& candidate : fs::directory_iterator(folder)) {
    if (!fs::exists(candidate / "images.bin")) continue;
    Reconstruction model = ReadReconstruction(candidate);
    if (model.images.size() > largest.images.size()) largest = std::move(model);
  }
  return largest;
}

}  // namespace

StageCost Total(const StepCosts& costs) {
  StageCost total;
  for (const auto& [step, cost] : costs) {
    total.wall_s += cost.wall_s;
    total.cpu_s += cost.cpu_s;
  }
  return total;
}

PlainColmap::PlainColmap(fs::path folder, Camera camera, const SparseUpdateOptions& sift,
                         ColmapProgram* colmap)
    : folder_(std::move(folder)), camera_(std::move(camera)), sift_(sift), colmap_(colmap) {
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

StageCost PlainColmap::Timed(const std::string& command, const ColmapOptions& options) {
  const StageTimer timer;
  colmap_->Run(command, options, folder_ / (command + ".log"), {});
  return timer.Stop();
}

StageCost PlainColmap::Extract(const fs::path& images, const std::vector<std::string>& photos) {
  ColmapOptions options = {
      {"database_path", (folder_ / "database.db").string()},
      {"image_path", images.string()},
      {"SiftExtraction.use_gpu", "0"},
      {"SiftExtraction.first_octave", std::to_string(sift_.first_octave)},
      {"SiftExtraction.max_num_features", std::to_string(sift_.max_num_features)},
      {"SiftExtraction.max_image_size", std::to_string(sift_.max_image_size)}};
  if (photos.empty()) {
    options.emplace_back("ImageReader.single_camera", "1");
    options.emplace_back("ImageReader.camera_model",
                         GetCameraModelInfo(static_cast<int>(camera_.model)).name);
    options.emplace_back("ImageReader.camera_params", ParamsText(camera_));
  } else {
    std::string list;
    for (const std::string& name : photos) list += name + "\n";
    WriteFileAtomically(folder_ / "new.txt", list);
    options.emplace_back("image_list_path", (folder_ / "new.txt").string());
    options.emplace_back("ImageReader.existing_camera_id", "1");
  }
  return Timed("feature_extractor", options);
}

StageCost PlainColmap::Map(const fs::path& images, const fs::path& input) {
  const fs::path output = folder_ / ("models_" + std::to_string(num_models_++));
  fs::create_directories(output);
  ColmapOptions options = {{"database_path", (folder_ / "database.db").string()},
                           {"image_path", images.string()},
                           {"output_path", output.string()}};
  if (!input.empty()) options.emplace_back("input_path", input.string());
  const StageCost cost = Timed("mapper", options);
  model_ = input.empty() ? LargestModel(output) : ReadReconstruction(output);
  return cost;
}

StepCosts PlainColmap::FromScratch(const fs::path& images, int neighbors) {
  StepCosts costs;
  costs["features"] = Extract(images, {});
  ColmapOptions options = {{"database_path", (folder_ / "database.db").string()},
                           {"SiftMatching.use_gpu", "0"}};
  if (neighbors > 0) {
    options.emplace_back("SpatialMatching.max_num_neighbors", std::to_string(neighbors));
  }
  costs["matching"] = Timed("spatial_matcher", options);
  costs["mapping"] = Map(images, {});
  return costs;
}

StepCosts PlainColmap::Update(const fs::path& images, const std::vector<std::string>& new_photos,
                              const std::vector<std::pair<std::string, std::string>>& pairs) {
  const fs::path input = folder_ / "input";
  WriteReconstructionBinary(model_, input);
  StepCosts costs;
  costs["features"] = Extract(images, new_photos);
  std::string list;
  for (const auto& [first, second] : pairs) list.append(first).append(" ").append(second) += '\n';
  WriteFileAtomically(folder_ / "pairs.txt", list);
  costs["matching"] =
      Timed("matches_importer", {{"database_path", (folder_ / "database.db").string()},
                                 {"match_list_path", (folder_ / "pairs.txt").string()},
                                 {"match_type", "pairs"},
                                 {"SiftMatching.use_gpu", "0"}});
  costs["mapping"] = Map(images, input);
  return costs;
}

}  // namespace colmap_ext
