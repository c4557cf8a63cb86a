// Superpixel stereo by several processes: what each made of its photos, handed to the others as
// files of a folder that all of them see.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/stereo_options.h"
#include "colmap_ext/mvs/superpixels.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/job_rank.h"

namespace colmap_ext {

class PhotoExchange {
 public:
  // Files are written below `folder`, in one that no other run uses: named by `photos`, options and
  // the start of the processes. `rank` and `photos` must outlive it.
  PhotoExchange(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                const SuperpixelStereoOptions& options, std::filesystem::path folder,
                const JobRank& rank);

  const JobRank& rank() const { return rank_; }

  // Each call is the next step; all processes must call in the same order, with one entry a photo.
  // Own photos' entries are given to the others, theirs are filled in. Throws Error when another
  // process does not come along (WaitForFiles), CancelledError.
  void Share(const JobControl& job, std::vector<ImageMesh>* partitions);
  void Share(const JobControl& job, std::vector<FacetDepths>* depths);
  void Share(const JobControl& job, std::vector<std::vector<float>>* confidence);

  // After the last result is written. The first process waits for the others and removes `folder`.
  void Finish(const JobControl& job);

 private:
  template <typename Item>
  void ShareItems(const JobControl& job, std::vector<Item>* items);

  const PhotoSet& photos_;
  std::filesystem::path folder_, run_folder_;
  const JobRank& rank_;
  int step_ = 0;
};

}  // namespace colmap_ext
