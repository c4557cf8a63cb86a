#include "colmap_ext/mvs/photo_exchange.h"

#include <cstdio>

#include "colmap_ext/mvs/linear_stereo.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "mvs/content_hash.h"
#include "mvs/memory_keys.h"
#include "mvs/mesh_bytes.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Of everything that the result depends on.
std::uint64_t HashOf(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                     const SuperpixelStereoOptions& options, int num_processes) {
  const std::vector<std::vector<int>> points = PointsOfPhotos(photos);
  std::vector<std::uint64_t> keys(photos.photos.size());
  ParallelFor(keys.size(), [&](std::size_t i) {
    const std::uint64_t partition = PartitionKey(photos.photos[i], superpixel_options);
    keys[i] = SolveKey(partition, photos, i, points[i], options);
  });
  return ContentHash().Add(keys).Add(num_processes).value();
}

}  // namespace

PhotoExchange::PhotoExchange(const PhotoSet& photos, const SuperpixelOptions& superpixel_options,
                             const SuperpixelStereoOptions& options, fs::path folder,
                             const JobRank& rank)
    : photos_(photos), folder_(std::move(folder)), rank_(rank) {
  char hash[32];
  std::snprintf(
      hash, sizeof hash, "%016llx",
      static_cast<unsigned long long>(HashOf(photos, superpixel_options, options, rank.size)));
  run_folder_ = folder_ / (hash + ("_" + rank.launch));
}

template <typename Item>
void PhotoExchange::ShareItems(const JobControl& job, std::vector<Item>* items) {
  const fs::path folder = run_folder_ / std::to_string(step_++);
  const auto path_of = [&](std::size_t i) { return folder / (photos_.photos[i].name + ".bin"); };
  std::vector<fs::path> others;
  for (std::size_t i = 0; i < items->size(); ++i) {
    if (!rank_.IsMine(i)) others.push_back(path_of(i));
  }
  ParallelFor(items->size(), [&](std::size_t i) {
    if (!rank_.IsMine(i)) return;
    WriteFileAtomically(path_of(i), [&](std::ostream& out) { PutBytes((*items)[i], out); });
  });
  WaitForFiles(others, rank_, job);
  ParallelFor(items->size(), [&](std::size_t i) {
    if (rank_.IsMine(i)) return;
    ByteReader in(path_of(i));
    TakeBytes(&in, &(*items)[i]);
    in.ExpectEnd();
  });
}

void PhotoExchange::Share(const JobControl& job, std::vector<ImageMesh>* partitions) {
  ShareItems(job, partitions);
}

void PhotoExchange::Share(const JobControl& job, std::vector<FacetDepths>* depths) {
  ShareItems(job, depths);
}

void PhotoExchange::Share(const JobControl& job, std::vector<std::vector<float>>* confidence) {
  ShareItems(job, confidence);
}

void PhotoExchange::Finish(const JobControl& job) {
  const auto done = [&](int rank) { return run_folder_ / "done" / std::to_string(rank); };
  WriteFileAtomically(done(rank_.rank), "");
  if (!rank_.IsFirst()) return;
  std::vector<fs::path> all;
  for (int rank = 0; rank < rank_.size; ++rank) all.push_back(done(rank));
  WaitForFiles(all, rank_, job);
  fs::remove_all(folder_);
}

}  // namespace colmap_ext
