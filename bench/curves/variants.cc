#include "variants.h"

#include <algorithm>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"

namespace colmap_ext {
namespace {

Variant Planner(const std::string& strategy, const std::string& what) {
  return {strategy, what, {"--NextBestView.strategy", strategy}};
}

Variant GpsNoise(const std::string& sigma_m) {
  return {"gps_" + sigma_m + "m",
          "GPS noise of " + sigma_m + " m, each axis",
          {"--Simulation.gps_noise_m", sigma_m}};
}

// Photos of the same view, `width_px` wide: 640 x 368 with a focal length of 480 px, scaled.
Variant PhotoWidth(int width_px) {
  return {"width_" + std::to_string(width_px),
          "photos " + std::to_string(width_px) + " px wide",
          {"--Simulation.width", std::to_string(width_px), "--Simulation.height",
           std::to_string(width_px * 368 / 640), "--Simulation.focal_px",
           std::to_string(width_px * 480 / 640), "--Session.max_image_size_px",
           std::to_string(std::max(width_px, 640))}};
}

struct Kind {
  const char* name;
  std::vector<Variant> variants;
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds{
      {"planners",
       {Planner("submodular", "the usual session"), Planner("plane_sweep", "the paper's planner"),
        Planner("smith2018", "offline planner after Smith et al. 2018"),
        Planner("next_farthest_point", "looks at the uncovered point furthest from all views"),
        Planner("random", "random views that can be reached"),
        Planner("hemisphere", "views on a hemisphere around the site")}},
      {"stereo",
       {{"no_fusion", "no multi-view fusion", {"--SuperpixelStereo.fusion_passes", "0"}},
        {"no_photometric", "no photometric stage", {"--SuperpixelStereo.photometric", "0"}},
        {"sfm_only",
         "neither",
         {"--SuperpixelStereo.fusion_passes", "0", "--SuperpixelStereo.photometric", "0"}}}},
      {"coverage",
       {// Points that no surface has: none is covered by its signal.
        {"views_only",
         "coverage by good views only, no Poisson signal",
         {"--Coverage.strong_spacing_m", "1e-6"}},
        // Views that no point has: none is covered by them.
        {"signal_only",
         "coverage by the Poisson signal only, no good views",
         {"--Coverage.min_good_views", "1000"}},
        {"predicted_error",
         "coverage by the predicted error",
         {"--Coverage.target_error_mm", "50.8"}}}},
      {"gps", {GpsNoise("0"), GpsNoise("0.5"), GpsNoise("1.5"), GpsNoise("3")}},
      {"width", {PhotoWidth(320), PhotoWidth(1280)}}};
  return kinds;
}

void Append(const std::string& name, std::vector<Variant>* chosen) {
  const auto add = [&](const Variant& variant) {
    const auto same = [&](const Variant& other) { return other.name == variant.name; };
    if (std::none_of(chosen->begin(), chosen->end(), same)) chosen->push_back(variant);
  };
  std::string known = "all";
  bool is_found = name == "all";
  for (const Kind& kind : Kinds()) {
    known += ", " + std::string(kind.name);
    if (name == kind.name) {
      is_found = true;
      add(AllVariants().front());
      for (const Variant& variant : kind.variants) add(variant);
    }
  }
  for (const Variant& variant : AllVariants()) {
    known += ", " + variant.name;
    if (name == "all" || name == variant.name) {
      is_found = true;
      add(variant);
    }
  }
  if (!is_found) throw UsageError("--variants: \"" + name + "\" is none of " + known);
}

}  // namespace

const std::vector<Variant>& AllVariants() {
  static const std::vector<Variant> all = [] {
    std::vector<Variant> variants;
    for (const Kind& kind : Kinds()) {
      variants.insert(variants.end(), kind.variants.begin(), kind.variants.end());
    }
    return variants;
  }();
  return all;
}

std::vector<Variant> VariantsOf(const std::string& list) {
  std::vector<Variant> chosen;
  for (const std::string& name : SplitAtCommas(list)) Append(name, &chosen);
  if (chosen.empty()) throw UsageError("--variants is empty");
  return chosen;
}

}  // namespace colmap_ext
