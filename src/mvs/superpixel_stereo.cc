#include "colmap_ext/mvs/superpixel_stereo.h"

#include <algorithm>
#include <atomic>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/neighbors.h"
#include "colmap_ext/mvs/photometric.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "mvs/memory_keys.h"
#include "mvs/raster.h"

namespace colmap_ext {
namespace {

void RequirePixels(const PhotoSet& photos) {
  for (const PosedPhoto& photo : photos.photos) {
    if (photo.bgr.cols != photo.camera.width || photo.bgr.rows != photo.camera.height ||
        photo.bgr.empty()) {
      throw Error("superpixel stereo: photo " + photo.name +
                  " has no pixels or not the size of its camera");
    }
  }
}

// Calls work(i) for each photo in parallel, with progress.
template <typename Work>
void ForEachPhoto(std::size_t count, const char* stage, const JobControl& job, const Work& work) {
  std::atomic<std::size_t> done = 0;
  ParallelFor(count, [&](std::size_t i) {
    job.ThrowIfCancelled();
    work(i);
    job.Progress(stage, ++done, count);
  });
}

// The stages of one run, each photo's part taken from the memory where its input is what it was.
class StereoRun {
 public:
  StereoRun(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
            const SuperpixelStereoOptions& options, const JobControl& job, bool remembers,
            PhotoExchange* exchange, StereoMemory* memory)
      : photos_(photos),
        superpixel_options_(superpixel_options),
        options_(options),
        job_(job),
        remembers_(remembers),
        exchange_(exchange) {
    // Photos that are gone are forgotten.
    std::map<std::string, PhotoMemory> present;
    for (const PosedPhoto& photo : photos.photos) {
      present[photo.name] = std::move(memory->photo[photo.name]);
    }
    memory->photo.swap(present);
    photo_rows_.resize(photos.photos.size());
    for (const PosedPhoto& photo : photos.photos) {
      memory_.push_back(&memory->photo.at(photo.name));
    }
  }

  SuperpixelStereoResult Run() {
    const StageTimer superpixel_timer;
    Segment();
    result_.superpixels = superpixel_timer.Stop();
    const StageTimer stereo_timer;
    SolveInitially();
    result_.stereo = stereo_timer.Stop();
    const StageTimer photometric_timer;
    EvaluateConfidence(lookups_, result_.neighbors, options_, &result_.views);
    if (options_.photometric) RefineByPhotos();
    result_.photometric = photometric_timer.Stop();
    const StageTimer fusion_timer;
    Fuse();
    result_.fusion = fusion_timer.Stop();
    return std::move(result_);
  }

 private:
  std::size_t count() const { return photos_.photos.size(); }
  // Not another process's.
  bool IsMine(std::size_t i) const { return exchange_ == nullptr || exchange_->rank().IsMine(i); }

  // Over-segmentation into polygons, split into triangles.
  void Segment() {
    std::atomic<int> reused = 0;
    ForEachPhoto(count(), "superpixels", job_, [&](std::size_t i) {
      if (!IsMine(i)) return;
      const PosedPhoto& photo = photos_.photos[i];
      PhotoMemory& memory = *memory_[i];
      const std::uint64_t key = PartitionKey(photo, superpixel_options_);
      if (memory.partition != nullptr && memory.partition_key == key) {
        ++reused;
        return;
      }
      memory = {};
      memory.partition_key = key;
      memory.partition = std::make_shared<ImageMesh>(SegmentPhoto(photo.bgr, superpixel_options_));
      memory.triangle_at =
          RasterizeTriangleIds(*memory.partition, photo.camera.width, photo.camera.height);
    });
    result_.reused.partitions = reused;
    if (exchange_ != nullptr) SharePartitions();
  }

  void SharePartitions() {
    std::vector<ImageMesh> partitions(count());
    for (std::size_t i = 0; i < count(); ++i) {
      if (IsMine(i)) partitions[i] = *memory_[i]->partition;
    }
    exchange_->Share(job_, &partitions);
    ParallelFor(count(), [&](std::size_t i) {
      if (IsMine(i)) return;
      const PinholeCamera& camera = photos_.photos[i].camera;
      memory_[i]->partition = std::make_shared<ImageMesh>(std::move(partitions[i]));
      memory_[i]->triangle_at =
          RasterizeTriangleIds(*memory_[i]->partition, camera.width, camera.height);
    });
  }

  // Initialization: each view alone, without the fusion term.
  void SolveInitially() {
    result_.neighbors = FindNeighbors(photos_, options_);
    const std::vector<std::vector<int>> points = PointsOfPhotos(photos_);
    result_.views.resize(count());
    solve_keys_.resize(count());
    std::vector<std::unique_ptr<ViewLookup>> lookups(count());
    std::atomic<int> reused = 0;
    ForEachPhoto(count(), "stereo", job_, [&](std::size_t i) {
      if (!IsMine(i)) return;
      PhotoMemory& memory = *memory_[i];
      solve_keys_[i] = SolveKey(memory.partition_key, photos_, i, points[i], options_);
      if (memory.solver != nullptr && memory.solve_key == solve_keys_[i]) {
        ++reused;
      } else {
        memory.solve_key = solve_keys_[i];
        memory.solver =
            std::make_shared<LinearStereo>(photos_, static_cast<int>(i), points[i],
                                           *memory.partition, memory.triangle_at, options_);
      }
      result_.views[i] = memory.solver->initial();
      result_.views[i].photo_index = static_cast<int>(i);  // photos before it may be new
      lookups[i] = std::make_unique<ViewLookup>(result_.views[i], memory.triangle_at);
    });
    result_.reused.solves = reused;
    if (exchange_ != nullptr) ShareInitialViews(&lookups);
    for (std::size_t i = 0; i < count(); ++i) {
      if (exchange_ == nullptr) solvers_.push_back(*memory_[i]->solver);
      lookups_.push_back(std::move(*lookups[i]));
    }
  }

  void ShareInitialViews(std::vector<std::unique_ptr<ViewLookup>>* lookups) {
    std::vector<FacetDepths> depths(count());
    for (std::size_t i = 0; i < count(); ++i) {
      if (IsMine(i)) depths[i] = {result_.views[i].inverse_depth, result_.views[i].supported};
    }
    exchange_->Share(job_, &depths);
    ParallelFor(count(), [&](std::size_t i) {
      if (IsMine(i)) return;
      ViewMesh& view = result_.views[i];
      view.photo_index = static_cast<int>(i);
      view.camera = photos_.photos[i].camera;
      view.cam_from_world = photos_.photos[i].cam_from_world;
      view.image = *memory_[i]->partition;
      view.inverse_depth = std::move(depths[i].inverse_depth);
      view.supported = std::move(depths[i].supported);
      view.confidence.assign(view.image.triangles.size(), 0.0F);
      (*lookups)[i] = std::make_unique<ViewLookup>(view, memory_[i]->triangle_at);
    });
  }

  // What the photos say about the facets, solved with no facet fixed; then confidence anew.
  void RefineByPhotos() {
    photometric_ = std::make_unique<PhotometricStage>(photos_, result_.neighbors, options_);
    const std::vector<std::uint64_t> view_keys = ViewKeys();
    ForEachPhoto(count(), "photo-consistency", job_, [&](std::size_t i) {
      if (!IsMine(i)) return;
      PhotoMemory::PhotometricPass& pass = memory_[i]->photometric;
      const std::uint64_t key = PassKey(view_keys, i, result_.neighbors[i], {});
      if (pass.key == key) return;
      const ViewMesh& view = result_.views[i];
      pass.rows = photometric_->CollectRows(result_.views, lookups_, static_cast<int>(i));
      pass.depths = {view.inverse_depth, view.supported};
      if (!pass.rows.empty()) {
        const std::vector<std::uint8_t> none_fixed(view.supported.size(), 0);
        memory_[i]->solver->Refine(none_fixed, pass.rows, &pass.depths.inverse_depth,
                                   &pass.depths.supported);
      }
      pass.key = key;
    });
    if (exchange_ != nullptr) SharePhotometricPasses();
    cues_.resize(count());
    ParallelFor(count(), [&](std::size_t i) {
      const PhotoMemory::PhotometricPass& pass = memory_[i]->photometric;
      photo_rows_[i] = pass.rows;
      result_.views[i].inverse_depth = pass.depths.inverse_depth;
      result_.views[i].supported = pass.depths.supported;
      lookups_[i] = ViewLookup(result_.views[i], lookups_[i].triangle_at);
    });
    EvaluateConfidence(lookups_, result_.neighbors, options_, &result_.views);
    WeighConfidence(std::vector<std::vector<std::uint8_t>>(count()));
  }

  void SharePhotometricPasses() {
    std::vector<FacetDepths> depths(count());
    for (std::size_t i = 0; i < count(); ++i) depths[i] = memory_[i]->photometric.depths;
    exchange_->Share(job_, &depths);
    for (std::size_t i = 0; i < count(); ++i) {
      memory_[i]->photometric.depths = std::move(depths[i]);
    }
  }

  // Photo-consistency as the fourth factor of Γ; cues of facets with keep[i][t] != 0 are still
  // those of their planes.
  void WeighConfidence(const std::vector<std::vector<std::uint8_t>>& keep) {
    ParallelFor(count(), [&](std::size_t i) {
      if (!IsMine(i)) return;
      photometric_->EvaluateCues(result_.views, lookups_, static_cast<int>(i), keep[i], &cues_[i]);
      std::vector<float>& confidence = result_.views[i].confidence;
      for (std::size_t t = 0; t < confidence.size(); ++t) {
        confidence[t] *= static_cast<float>(PhotoConsistency(cues_[i][t], options_));
      }
    });
    if (exchange_ != nullptr) ShareConfidence();
  }

  void ShareConfidence() {
    std::vector<std::vector<float>> confidence(count());
    for (std::size_t i = 0; i < count(); ++i) confidence[i].swap(result_.views[i].confidence);
    exchange_->Share(job_, &confidence);
    for (std::size_t i = 0; i < count(); ++i) confidence[i].swap(result_.views[i].confidence);
  }

  // Multi-view depth fusion.
  void Fuse() {
    for (int pass = 0; pass < options_.fusion_passes; ++pass) {
      std::vector<std::vector<std::uint8_t>> fixed(count());
      for (std::size_t i = 0; i < count(); ++i) {
        for (const float confidence : result_.views[i].confidence) {
          fixed[i].push_back(confidence > options_.fixed_confidence);
        }
      }
      const double moving_share = FuseOnce(static_cast<std::size_t>(pass), photo_rows_);
      if (photometric_) WeighConfidence(fixed);
      job_.Progress("fusion", static_cast<std::size_t>(pass) + 1,
                    static_cast<std::size_t>(options_.fusion_passes));
      if (moving_share < options_.fusion_moving_share) break;
    }
  }

  std::vector<std::uint64_t> ViewKeys() const {
    std::vector<std::uint64_t> keys(count());
    ParallelFor(count(),
                [&](std::size_t i) { keys[i] = ViewKey(solve_keys_[i], result_.views[i]); });
    return keys;
  }

  double FuseOnce(std::size_t pass, const std::vector<std::vector<DepthRow>>& extra_rows) {
    const std::vector<std::uint64_t> view_keys = ViewKeys();
    std::vector<std::uint64_t> pass_keys(count());
    std::vector<const FacetDepths*> known(count());
    for (std::size_t i = 0; remembers_ && i < count(); ++i) {
      pass_keys[i] = PassKey(view_keys, i, result_.neighbors[i], extra_rows[i]);
      std::vector<PhotoMemory::Pass>& passes = memory_[i]->passes;
      passes.resize(std::max(passes.size(), pass + 1));
      if (passes[pass].key == pass_keys[i]) known[i] = &passes[pass].depths;
      result_.reused.passes += known[i] != nullptr;
    }
    const std::vector<FacetDepths> together = FuseTogether(extra_rows);
    for (std::size_t i = 0; i < together.size(); ++i) known[i] = &together[i];
    const double moving_share = FuseViews(solvers_, result_.neighbors, extra_rows, known, options_,
                                          job_, &lookups_, &result_.views);
    for (std::size_t i = 0; remembers_ && i < count(); ++i) {
      if (known[i] != nullptr) continue;
      const ViewMesh& view = result_.views[i];
      memory_[i]->passes[pass] = {pass_keys[i], {view.inverse_depth, view.supported}};
    }
    return moving_share;
  }

  // Of several processes: the result of one pass for each photo. Of one: empty.
  std::vector<FacetDepths> FuseTogether(const std::vector<std::vector<DepthRow>>& extra_rows) {
    if (exchange_ == nullptr) return {};
    std::vector<FacetDepths> depths(count());
    ParallelFor(count(), [&](std::size_t i) {
      if (!IsMine(i)) return;
      job_.ThrowIfCancelled();
      depths[i] = FuseView(*memory_[i]->solver, result_.views, lookups_, result_.neighbors[i],
                           extra_rows[i], static_cast<int>(i), options_);
    });
    exchange_->Share(job_, &depths);
    return depths;
  }

  const PhotoSet& photos_;
  const SuperpixelOptions& superpixel_options_;
  const SuperpixelStereoOptions& options_;
  const JobControl& job_;
  const bool remembers_;              // false: `memory` is dropped after the run
  PhotoExchange* const exchange_;     // null: this process does all photos
  std::vector<PhotoMemory*> memory_;  // of each photo
  std::vector<std::uint64_t> solve_keys_;
  std::vector<LinearStereo> solvers_;  // empty with an exchange
  std::vector<ViewLookup> lookups_;
  std::unique_ptr<PhotometricStage> photometric_;  // null: without
  std::vector<std::vector<DepthRow>> photo_rows_;  // of each photo, empty without
  std::vector<std::vector<PhotoCue>> cues_;        // of each photo's triangles
  SuperpixelStereoResult result_;
};

SuperpixelStereoResult CheckAndRun(const PhotoSet& photos,
                                   const SuperpixelOptions& superpixel_options,
                                   const SuperpixelStereoOptions& options, const JobControl& job,
                                   bool remembers, PhotoExchange* exchange, StereoMemory* memory) {
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(options.Check());
  RequirePixels(photos);
  return StereoRun(photos, superpixel_options, options, job, remembers, exchange, memory).Run();
}

}  // namespace

SuperpixelStereoResult RunSuperpixelStereo(const PhotoSet& photos,
                                           const SuperpixelOptions& superpixel_options,
                                           const SuperpixelStereoOptions& options,
                                           const JobControl& job) {
  StereoMemory memory;
  return CheckAndRun(photos, superpixel_options, options, job, false, nullptr, &memory);
}

SuperpixelStereoResult ShareSuperpixelStereo(const PhotoSet& photos,
                                             const SuperpixelOptions& superpixel_options,
                                             const SuperpixelStereoOptions& options,
                                             const JobControl& job, PhotoExchange* exchange) {
  StereoMemory memory;
  return CheckAndRun(photos, superpixel_options, options, job, false, exchange, &memory);
}

SuperpixelStereoResult UpdateSuperpixelStereo(const PhotoSet& photos,
                                              const SuperpixelOptions& superpixel_options,
                                              const SuperpixelStereoOptions& options,
                                              const JobControl& job, StereoMemory* memory) {
  return CheckAndRun(photos, superpixel_options, options, job, true, nullptr, memory);
}

}  // namespace colmap_ext
