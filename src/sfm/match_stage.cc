#include "match_stage.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "guided_matching.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPairsPerRun = 64;

using MatchSpan = std::span<const PairMatches>;

std::vector<ImageId> ImagesOf(MatchSpan matches) {
  std::set<ImageId> ids;
  for (const PairMatches& pair_matches : matches) {
    ids.insert(pair_matches.pair.first);
    ids.insert(pair_matches.pair.second);
  }
  return {ids.begin(), ids.end()};
}

// A database of only the photos of a run, named by their ids: the file of matches separates names
// by blanks, which a photo's own name may hold.
void WriteRunDatabase(MatchSpan matches, const DatabaseView& database,
                      const fs::path& empty_database, const fs::path& run_database) {
  Database::Copy(empty_database, run_database);
  Database run = Database::Open(run_database, Database::Access::kReadWrite);
  Database::Transaction transaction(run);
  const std::map<ImageId, DatabaseImage> images = database.ReadImages();
  const std::map<CameraId, DatabaseCamera> cameras = database.ReadCameras();
  std::set<CameraId> written;
  for (const ImageId id : ImagesOf(matches)) {
    const DatabaseImage& image = images.at(id);
    if (written.insert(image.camera_id).second) {
      transaction.InsertCamera(image.camera_id, cameras.at(image.camera_id));
    }
    transaction.InsertImage(id, {std::to_string(id), image.camera_id, std::nullopt});
    transaction.InsertKeypoints(id, database.ReadKeypoints(id));
  }
  transaction.Commit();
}

std::string MatchListText(MatchSpan matches) {
  std::string text;
  for (const PairMatches& pair_matches : matches) {
    text += std::to_string(pair_matches.pair.first) + " " +
            std::to_string(pair_matches.pair.second) + "\n";
    for (const KeypointMatch& match : pair_matches.matches) {
      text += std::to_string(match.first) + " " + std::to_string(match.second) + "\n";
    }
    text += "\n";
  }
  return text;
}

std::vector<TwoViewGeometry> VerifyRun(MatchSpan matches, const UpdateDatabase& databases,
                                       const fs::path& folder, const fs::path& log_path,
                                       ColmapProgram* colmap, const JobControl& job) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path run_database = folder / "run.db";
  WriteRunDatabase(matches, DatabaseView(databases), databases.empty_database(), run_database);
  WriteFileAtomically(folder / "matches.txt", MatchListText(matches));
  colmap->Run("matches_importer",
              {{"database_path", run_database.string()},
               {"match_list_path", (folder / "matches.txt").string()},
               {"match_type", "raw"},
               {"SiftMatching.use_gpu", "0"}},
              log_path, job);
  std::vector<TwoViewGeometry> geometries;
  const Database run = Database::Open(run_database, Database::Access::kReadOnly);
  for (const PairMatches& pair_matches : matches) {
    std::optional<TwoViewGeometry> geometry = run.ReadTwoViewGeometry(pair_matches.pair);
    if (!geometry) {
      throw Error("`colmap matches_importer` left out a pair of photos; its output: " +
                  log_path.string());
    }
    geometries.push_back(std::move(*geometry));
  }
  fs::remove_all(folder);
  return geometries;
}

Eigen::Matrix2Xf PixelsOf(const KeypointMatrix& keypoints) {
  Eigen::Matrix2Xf pixels(2, keypoints.rows());
  if (keypoints.rows() > 0) pixels = keypoints.leftCols(2).transpose();
  return pixels;
}

// On the plane at distance 1; what the camera cannot have taken is nowhere near a line.
Eigen::Matrix2Xf NormalizedOf(const Eigen::Matrix2Xf& pixels, const Camera& camera) {
  Eigen::Matrix2Xf points(2, pixels.cols());
  for (Eigen::Index k = 0; k < pixels.cols(); ++k) {
    const std::optional<Eigen::Vector2d> point =
        NormalizedFromImage(camera, pixels.col(k).cast<double>());
    points.col(k) = point.value_or(Eigen::Vector2d::Constant(1e9)).cast<float>();
  }
  return points;
}

// What guided matching needs of a photo.
struct PhotoFeatures {
  Eigen::Matrix2Xf pixels, normalized;
  DescriptorMatrix descriptors;
  double focal_px = 0;
};

bool IsGuide(const TwoViewGeometry& geometry) {
  return geometry.inlier_matches.size() >= kMinInliers &&
         (geometry.config == TwoViewConfig::kCalibrated ||
          geometry.config == TwoViewConfig::kUncalibrated);
}

std::map<ImageId, PhotoFeatures> ReadFeatures(const std::set<ImageId>& ids,
                                              const DatabaseView& database) {
  const std::map<ImageId, DatabaseImage> images = database.ReadImages();
  const std::map<CameraId, DatabaseCamera> cameras = database.ReadCameras();
  std::map<ImageId, PhotoFeatures> features;
  for (const ImageId id : ids) {
    const Camera& camera = cameras.at(images.at(id).camera_id).camera;
    PhotoFeatures& photo = features[id];
    photo.pixels = PixelsOf(database.ReadKeypoints(id));
    photo.normalized = NormalizedOf(photo.pixels, camera);
    photo.descriptors = database.ReadDescriptors(id);
    photo.focal_px = camera.params[0];
    if (photo.descriptors.rows() == photo.pixels.cols()) continue;
    throw Error(database.path().string() + ": image " + std::to_string(id) +
                " has not as many descriptors as keypoints");
  }
  return features;
}

GuidedPhoto GuidedPhotoOf(const PhotoFeatures& photo, bool normalized, double max_error_px) {
  const double unit_px = normalized ? photo.focal_px : 1;
  return {normalized ? photo.normalized : photo.pixels,
          {photo.descriptors.data(), static_cast<int>(photo.descriptors.rows())},
          static_cast<float>(max_error_px / unit_px)};
}

// Adds what matches along the epipolar lines of the pairs that passed.
void GuideMatches(const std::vector<PairMatches>& all_matches, const DatabaseView& database,
                  const MatchingOptions& options, const JobControl& job,
                  std::vector<std::vector<TwoViewGeometry>>* runs) {
  std::vector<std::size_t> guides;
  std::set<ImageId> ids;
  for (std::size_t i = 0; i < all_matches.size(); ++i) {
    if (!IsGuide((*runs)[i / kPairsPerRun][i % kPairsPerRun])) continue;
    guides.push_back(i);
    ids.insert({all_matches[i].pair.first, all_matches[i].pair.second});
  }
  const std::map<ImageId, PhotoFeatures> features = ReadFeatures(ids, database);
  ParallelFor(guides.size(), [&](std::size_t k) {
    if (job.IsCancelled()) return;
    const std::size_t i = guides[k];
    TwoViewGeometry& geometry = (*runs)[i / kPairsPerRun][i % kPairsPerRun];
    const bool normalized = geometry.config == TwoViewConfig::kCalibrated;
    const double max_error_px = options.guided_max_error_px;
    geometry.inlier_matches = AddGuidedMatches(
        GuidedPhotoOf(features.at(all_matches[i].pair.first), normalized, max_error_px),
        GuidedPhotoOf(features.at(all_matches[i].pair.second), normalized, max_error_px),
        normalized ? geometry.E : geometry.F, geometry.inlier_matches, options);
  });
  job.ThrowIfCancelled();
}

void Store(const std::vector<PairMatches>& all_matches,
           const std::vector<std::vector<TwoViewGeometry>>& runs, const fs::path& database_path) {
  Database database = Database::Open(database_path, Database::Access::kReadWrite);
  Database::Transaction transaction(database);
  for (std::size_t i = 0; i < all_matches.size(); ++i) {
    transaction.InsertMatches(all_matches[i].pair, all_matches[i].matches);
    transaction.InsertTwoViewGeometry(all_matches[i].pair,
                                      runs[i / kPairsPerRun][i % kPairsPerRun]);
  }
  transaction.Commit();
}

}  // namespace

std::vector<PairMatches> MatchImagePairs(const DatabaseView& database,
                                         const std::vector<ImagePair>& pairs,
                                         const MatchingOptions& options, const JobControl& job) {
  std::map<ImageId, int> index_of_image;
  for (const ImagePair& pair : pairs) {
    index_of_image.emplace(pair.first, 0);
    index_of_image.emplace(pair.second, 0);
  }
  std::vector<DescriptorMatrix> descriptors;
  for (auto& [id, index] : index_of_image) {
    index = static_cast<int>(descriptors.size());
    descriptors.push_back(database.ReadDescriptors(id));
    if (descriptors.back().rows() > 0 && descriptors.back().cols() != kDescriptorSize) {
      throw Error(database.path().string() + ": the descriptors of image " + std::to_string(id) +
                  " have " + std::to_string(descriptors.back().cols()) +
                  " values; only SIFT's 128 can be matched");
    }
  }
  std::vector<DescriptorView> views;
  for (const DescriptorMatrix& matrix : descriptors) {
    views.push_back({matrix.data(), static_cast<int>(matrix.rows())});
  }
  std::vector<PhotoPair> index_pairs;
  for (const ImagePair& pair : pairs) {
    index_pairs.emplace_back(index_of_image.at(pair.first), index_of_image.at(pair.second));
  }
  std::vector<std::vector<KeypointMatch>> matches =
      MatchPhotoPairs(views, index_pairs, options, job);
  std::vector<PairMatches> result;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    result.push_back({pairs[i], std::move(matches[i])});
  }
  return result;
}

void VerifyAndStore(const std::vector<PairMatches>& all_matches, const UpdateDatabase& databases,
                    const fs::path& work_path, const MatchingOptions& options,
                    ColmapProgram* colmap, const JobControl& job) {
  if (all_matches.empty()) return;
  const std::size_t num_runs = (all_matches.size() + kPairsPerRun - 1) / kPairsPerRun;
  std::vector<std::vector<TwoViewGeometry>> runs(num_runs);
  std::vector<std::exception_ptr> failures(num_runs);
  std::atomic<std::size_t> done = 0;
  colmap->dialect().HasOption("matches_importer", "match_type");  // asked before the threads start
  ParallelFor(num_runs, [&](std::size_t i) {
    if (job.IsCancelled()) return;
    const std::size_t begin = i * kPairsPerRun;
    const std::size_t count = std::min(kPairsPerRun, all_matches.size() - begin);
    const std::string name = "verification_" + std::to_string(i);
    try {
      runs[i] = VerifyRun(MatchSpan(all_matches).subspan(begin, count), databases, work_path / name,
                          work_path / (name + ".log"), colmap, job);
    } catch (...) {
      failures[i] = std::current_exception();
    }
    job.Progress("verification", ++done, num_runs);
  });
  job.ThrowIfCancelled();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  if (options.guided_max_error_px > 0) {
    GuideMatches(all_matches, DatabaseView(databases), options, job, &runs);
  }
  Store(all_matches, runs, databases.draft());
}

}  // namespace colmap_ext
