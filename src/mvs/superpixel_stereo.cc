#include "colmap_ext/mvs/superpixel_stereo.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>

#include "colmap_ext/mvs/confidence.h"
#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/mvs/photometric.h"
#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"
#include "mvs/memory_keys.h"
#include "mvs/raster.h"

namespace colmap_ext {
namespace {

void RequirePixels(const PhotoSet& photos, const std::vector<std::uint8_t>& needs_pixels) {
  for (std::size_t i = 0; i < photos.photos.size(); ++i) {
    const PosedPhoto& photo = photos.photos[i];
    if (needs_pixels[i] == 0) continue;
    if (photo.bgr.cols != photo.camera.width || photo.bgr.rows != photo.camera.height ||
        photo.bgr.empty()) {
      throw Error("superpixel stereo: photo " + photo.name +
                  " has no pixels or not the size of its camera");
    }
  }
}

// Calls work(i) for each of `which` in parallel, with progress.
template <typename Work>
void ForEachPhoto(const std::vector<std::size_t>& which, const char* stage, const JobControl& job,
                  const Work& work) {
  std::atomic<std::size_t> done = 0;
  ParallelFor(which.size(), [&](std::size_t k) {
    job.ThrowIfCancelled();
    work(which[k]);
    job.Progress(stage, ++done, which.size());
  });
}

// The mesh of an earlier update, in the world as it is now.
ViewMesh MeshNow(const SettledPhoto& settled, double scale, const PosedPhoto& photo, int index) {
  ViewMesh view = settled.view;
  view.photo_index = index;
  view.camera = photo.camera;
  view.cam_from_world = photo.cam_from_world;
  for (Eigen::Vector3d& corners : view.inverse_depth) corners /= scale;
  return view;
}

SettledPhoto::Neighbor AsItStands(const PosedPhoto& photo) {
  return {photo.name, photo.camera, photo.cam_from_world};
}

// The stages of one run.
class StereoRun {
 public:
  // `memory`: what `update` was planned with. `exchange`: null when this process does all photos;
  // else no photo is kept.
  StereoRun(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
            const SuperpixelStereoOptions& options, const StereoUpdate& update,
            const StereoMemory& memory, const JobControl& job, PhotoExchange* exchange)
      : photos_(photos),
        superpixel_options_(superpixel_options),
        options_(options),
        update_(update),
        memory_(memory),
        job_(job),
        exchange_(exchange),
        partition_keys_(photos.photos.size()),
        triangle_at_(photos.photos.size()),
        solvers_(photos.photos.size()),
        lookups_(photos.photos.size()),
        photo_rows_(photos.photos.size()),
        cues_(photos.photos.size()) {
    result_.neighbors = update.neighbors;
    result_.views.resize(count());
    for (std::size_t i = 0; i < count(); ++i) {
      if (!update.settled_scale[i]) solved_.push_back(i);
      if (!update.settled_scale[i] && IsMine(i)) mine_.push_back(i);
    }
  }

  SuperpixelStereoResult Run() {
    const StageTimer superpixel_timer;
    Segment();
    result_.superpixels = superpixel_timer.Stop();
    const StageTimer stereo_timer;
    TakeSettledMeshes();
    SolveInitially();
    result_.stereo = stereo_timer.Stop();
    const StageTimer photometric_timer;
    EvaluateConfidence(lookups_, result_.neighbors, solved_, options_, &result_.views);
    if (options_.photometric) RefineByPhotos();
    result_.photometric = photometric_timer.Stop();
    const StageTimer fusion_timer;
    Fuse();
    result_.fusion = fusion_timer.Stop();
    return std::move(result_);
  }

  // After Run: photos that are gone are forgotten, those that were solved are remembered.
  void Remember(const SuperpixelStereoResult& result, StereoMemory* memory) const {
    const std::vector<std::vector<int>> points = PointsOfPhotos(photos_);
    std::map<std::string, SettledPhoto> present;
    for (std::size_t i = 0; i < count(); ++i) {
      const PosedPhoto& photo = photos_.photos[i];
      SettledPhoto& settled = present[photo.name];
      if (update_.settled_scale[i]) {
        settled = std::move(memory->photo.at(photo.name));
        continue;
      }
      settled.stereo_key = StereoKey(superpixel_options_, options_);
      settled.partition_key = partition_keys_[i];
      settled.lens = photo.lens;
      settled.view = result.views[i];
      settled.num_points = points[i].size();
      for (const int j : update_.neighbors[i]) {
        settled.neighbors.push_back(AsItStands(photos_.photos[static_cast<std::size_t>(j)]));
      }
    }
    memory->photo.swap(present);
  }

 private:
  std::size_t count() const { return photos_.photos.size(); }
  // Not another process's.
  bool IsMine(std::size_t i) const { return exchange_ == nullptr || exchange_->rank().IsMine(i); }

  // Over-segmentation into polygons, split into triangles. It does not depend on the pose: a photo
  // that is solved again keeps its polygons.
  void Segment() {
    std::vector<ImageMesh> partitions(count());
    ForEachPhoto(mine_, "superpixels", job_, [&](std::size_t i) {
      const PosedPhoto& photo = photos_.photos[i];
      partition_keys_[i] = PartitionKey(photo, superpixel_options_);
      const auto before = memory_.photo.find(photo.name);
      const bool has_polygons =
          before != memory_.photo.end() && before->second.partition_key == partition_keys_[i];
      partitions[i] =
          has_polygons ? before->second.view.image : SegmentPhoto(photo.bgr, superpixel_options_);
    });
    if (exchange_ != nullptr) exchange_->Share(job_, &partitions);
    for (std::size_t i = 0; i < count(); ++i) result_.views[i].image = std::move(partitions[i]);
    ParallelFor(solved_.size(), [&](std::size_t k) { RasterizeView(solved_[k]); });
  }

  void RasterizeView(std::size_t i) {
    const PinholeCamera& camera = photos_.photos[i].camera;
    triangle_at_[i] = RasterizeTriangleIds(result_.views[i].image, camera.width, camera.height);
  }

  // Photos that keep their mesh; lookups of those that are a neighbour of one that is solved.
  void TakeSettledMeshes() {
    ParallelFor(count(), [&](std::size_t i) {
      if (!update_.settled_scale[i]) return;
      const PosedPhoto& photo = photos_.photos[i];
      result_.views[i] = MeshNow(memory_.photo.at(photo.name), *update_.settled_scale[i], photo,
                                 static_cast<int>(i));
      if (update_.needs_pixels[i] == 0) return;
      RasterizeView(i);
      lookups_[i] = ViewLookup(result_.views[i], triangle_at_[i]);
    });
  }

  // Initialization: each view alone, without the fusion term.
  void SolveInitially() {
    const std::vector<std::vector<int>> points = PointsOfPhotos(photos_);
    ForEachPhoto(mine_, "stereo", job_, [&](std::size_t i) {
      solvers_[i] =
          std::make_unique<LinearStereo>(photos_, static_cast<int>(i), points[i],
                                         result_.views[i].image, triangle_at_[i], options_);
      result_.views[i] = solvers_[i]->initial();
    });
    if (exchange_ != nullptr) ShareInitialViews();
    ParallelFor(solved_.size(), [&](std::size_t k) {
      const std::size_t i = solved_[k];
      lookups_[i] = ViewLookup(result_.views[i], triangle_at_[i]);
    });
  }

  void ShareInitialViews() {
    std::vector<FacetDepths> depths(count());
    for (const std::size_t i : mine_) {
      depths[i] = {result_.views[i].inverse_depth, result_.views[i].supported};
    }
    exchange_->Share(job_, &depths);
    ParallelFor(count(), [&](std::size_t i) {
      if (IsMine(i)) return;
      ViewMesh& view = result_.views[i];
      view.photo_index = static_cast<int>(i);
      view.camera = photos_.photos[i].camera;
      view.cam_from_world = photos_.photos[i].cam_from_world;
      view.inverse_depth = std::move(depths[i].inverse_depth);
      view.supported = std::move(depths[i].supported);
      view.confidence.assign(view.image.triangles.size(), 0.0F);
    });
  }

  // What the photos say about the facets, solved with no facet fixed; then confidence anew.
  void RefineByPhotos() {
    photometric_ = std::make_unique<PhotometricStage>(photos_, result_.neighbors, options_);
    std::vector<FacetDepths> depths(count());
    ForEachPhoto(mine_, "photo-consistency", job_, [&](std::size_t i) {
      const ViewMesh& view = result_.views[i];
      photo_rows_[i] = photometric_->CollectRows(result_.views, lookups_, static_cast<int>(i));
      depths[i] = {view.inverse_depth, view.supported};
      if (photo_rows_[i].empty()) return;
      const std::vector<std::uint8_t> none_fixed(view.supported.size(), 0);
      solvers_[i]->Refine(none_fixed, photo_rows_[i], &depths[i].inverse_depth,
                          &depths[i].supported);
    });
    AdoptDepths(&depths);
    WeighConfidence(std::vector<std::vector<std::uint8_t>>(count()));
  }

  // Makes new depths, this process's and the others', those of the views; then lookups and
  // confidence.
  void AdoptDepths(std::vector<FacetDepths>* depths) {
    if (exchange_ != nullptr) exchange_->Share(job_, depths);
    ParallelFor(solved_.size(), [&](std::size_t k) {
      const std::size_t i = solved_[k];
      result_.views[i].inverse_depth.swap((*depths)[i].inverse_depth);
      result_.views[i].supported.swap((*depths)[i].supported);
      lookups_[i] = ViewLookup(result_.views[i], triangle_at_[i]);
    });
    EvaluateConfidence(lookups_, result_.neighbors, solved_, options_, &result_.views);
  }

  // Photo-consistency as the fourth factor of Γ; cues of facets with keep[i][t] != 0 are still
  // those of their planes.
  void WeighConfidence(const std::vector<std::vector<std::uint8_t>>& keep) {
    ParallelFor(mine_.size(), [&](std::size_t k) {
      const std::size_t i = mine_[k];
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
      for (const std::size_t i : mine_) {
        for (const float confidence : result_.views[i].confidence) {
          fixed[i].push_back(confidence > options_.fixed_confidence);
        }
      }
      const double moving_share = FuseOnce();
      if (photometric_) WeighConfidence(fixed);
      job_.Progress("fusion", static_cast<std::size_t>(pass) + 1,
                    static_cast<std::size_t>(options_.fusion_passes));
      if (moving_share < options_.fusion_moving_share) break;
    }
  }

  // Every view from the result of the pass before. Returns the largest share of a view's facets
  // that moved.
  double FuseOnce() {
    std::vector<FacetDepths> depths(count());
    ParallelFor(mine_.size(), [&](std::size_t k) {
      job_.ThrowIfCancelled();
      const std::size_t i = mine_[k];
      depths[i] = FuseView(*solvers_[i], result_.views, lookups_, result_.neighbors[i],
                           photo_rows_[i], static_cast<int>(i), options_);
    });
    AdoptDepths(&depths);  // `depths` then has those of before
    double moving_share = 0;
    for (const std::size_t i : solved_) {
      moving_share =
          std::max(moving_share, MovedShare(depths[i].inverse_depth, result_.views[i].inverse_depth,
                                            options_.fusion_tolerance));
    }
    return moving_share;
  }

  const PhotoSet& photos_;
  const SuperpixelOptions& superpixel_options_;
  const SuperpixelStereoOptions& options_;
  const StereoUpdate& update_;
  const StereoMemory& memory_;
  const JobControl& job_;
  PhotoExchange* const exchange_;
  std::vector<std::size_t> solved_;            // photos that do not keep their mesh
  std::vector<std::size_t> mine_;              // of these, what this process works on
  std::vector<std::uint64_t> partition_keys_;  // of mine_
  std::vector<cv::Mat1i> triangle_at_;
  std::vector<std::unique_ptr<LinearStereo>> solvers_;  // of mine_
  std::vector<ViewLookup> lookups_;                     // of photos that need pixels
  std::unique_ptr<PhotometricStage> photometric_;       // null: without
  std::vector<std::vector<DepthRow>> photo_rows_;       // of mine_, empty without
  std::vector<std::vector<PhotoCue>> cues_;             // of mine_, one a triangle
  SuperpixelStereoResult result_;
};

// Every photo is solved.
SuperpixelStereoResult RunOnAll(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                                const SuperpixelStereoOptions& options, const JobControl& job,
                                PhotoExchange* exchange) {
  const StereoMemory nothing;
  const StereoUpdate update = PlanStereoUpdate(photos, superpixel_options, options, nothing);
  RequirePixels(photos, update.needs_pixels);
  return StereoRun(photos, superpixel_options, options, update, nothing, job, exchange).Run();
}

}  // namespace

SuperpixelStereoResult RunSuperpixelStereo(const PhotoSet& photos,
                                           const SuperpixelOptions& superpixel_options,
                                           const SuperpixelStereoOptions& options,
                                           const JobControl& job) {
  return RunOnAll(photos, superpixel_options, options, job, nullptr);
}

SuperpixelStereoResult ShareSuperpixelStereo(const PhotoSet& photos,
                                             const SuperpixelOptions& superpixel_options,
                                             const SuperpixelStereoOptions& options,
                                             const JobControl& job, PhotoExchange* exchange) {
  return RunOnAll(photos, superpixel_options, options, job, exchange);
}

SuperpixelStereoResult UpdateSuperpixelStereo(const PhotoSet& photos,
                                              const SuperpixelOptions& superpixel_options,
                                              const SuperpixelStereoOptions& options,
                                              const StereoUpdate& update, const JobControl& job,
                                              StereoMemory* memory) {
  ThrowIfInvalid(superpixel_options.Check());
  ThrowIfInvalid(options.Check());
  RequirePixels(photos, update.needs_pixels);
  StereoRun run(photos, superpixel_options, options, update, *memory, job, nullptr);
  SuperpixelStereoResult result = run.Run();
  run.Remember(result, memory);
  return result;
}

}  // namespace colmap_ext
