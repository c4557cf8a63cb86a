#include <cmath>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/sfm/sparse_update.h"

namespace colmap_ext {

std::string SparseUpdateOptions::Check() const {
  if (first_octave < -1 || first_octave > 4) {
    return "SparseUpdate.first_octave must be from -1 to 4";
  }
  if (max_num_features < 100) return "SparseUpdate.max_num_features must be at least 100";
  if (max_image_size < 100) return "SparseUpdate.max_image_size must be at least 100 px";
  if (!(adjust_after_growth >= 0 && adjust_after_growth <= 10)) {
    return "SparseUpdate.adjust_after_growth must be from 0 to 10";
  }
  if (refine_intrinsics < -1 || refine_intrinsics > 1) {
    return "SparseUpdate.refine_intrinsics must be -1, 0 or 1";
  }
  for (const std::string& complaint :
       {pairing.Check(), matching.Check(), georegistration.Check(), bundle.Check()}) {
    if (!complaint.empty()) return complaint;
  }
  return "";
}

void BindOptions(OptionSet& set, SparseUpdateOptions* options) {
  set.Add("SparseUpdate", "first_octave", &options->first_octave,
          "SIFT's first octave: 0 photo size, -1 doubled size, slower with more features (-1 … 4)");
  set.Add("SparseUpdate", "max_num_features", &options->max_num_features,
          "features a photo, the largest are kept (>= 100)");
  set.Add("SparseUpdate", "max_image_size", &options->max_image_size,
          "photos are scaled down to this longer side for SIFT (px, >= 100)");
  set.Add("SparseUpdate", "adjust_after_growth", &options->adjust_after_growth,
          "adjust all poses again when the model grew by this part since (0 … 10)");
  set.Add("SparseUpdate", "refine_intrinsics", &options->refine_intrinsics,
          "estimate focal length and distortion at the start: 0 no, 1 yes, -1 as fits");
  BindOptions(set, &options->pairing);
  BindOptions(set, &options->matching);
  BindOptions(set, &options->georegistration);
  BindOptions(set, &options->bundle);
}

SparseState ReadSparseState(const std::filesystem::path& path) {
  SparseState state;
  if (!std::filesystem::exists(path)) return state;
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  state.photos_at_last_adjustment = root["photos_at_last_adjustment"].Integer();
  for (const JsonNode& name : root["unregistered"].Items()) {
    state.unregistered.push_back(name.Text());
  }
  return state;
}

void WriteSparseState(const SparseState& state, const std::filesystem::path& path) {
  Json json;
  json["photos_at_last_adjustment"] = state.photos_at_last_adjustment;
  json["unregistered"] = state.unregistered;
  WriteJsonFile(json, path);
}

}  // namespace colmap_ext
