#include "colmap_ext/dense/builtin.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

#include "colmap_ext/dense/depth_estimate.h"
#include "colmap_ext/dense/depth_fusion.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/parallel.h"
#include "dense/point_dump.h"
#include "dense/remaining_time.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

void AppendDepths(const fs::path& map_path, std::vector<float>* depths) {
  constexpr std::size_t kStep = 31;  // enough for percentiles
  if (!fs::exists(map_path)) return;
  const DenseMap map = ReadDenseMap(map_path);
  for (std::size_t i = 0; i < map.data.size(); i += kStep) {
    if (map.data[i] > 0 && std::isfinite(map.data[i])) depths->push_back(map.data[i]);
  }
}

cv::Mat Inverted(const cv::Mat& map) {
  cv::Mat inverse = cv::Mat::zeros(map.size(), CV_32F);
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const float value = map.at<float>(y, x);
      if (value > 0) inverse.at<float>(y, x) = 1 / value;
    }
  }
  return inverse;
}

// Everything that the maps depend on, as text.
std::string Stamp(const PhotoSource& photos, const std::vector<std::vector<int>>& partners,
                  const std::vector<DepthRange>& ranges, const DenseStereoOptions& o) {
  std::ostringstream text;
  text << std::hexfloat << "colmap_ext builtin 1\n"
       << o.coarse_width_px << ' ' << o.residual_px << ' ' << o.block_px << ' '
       << o.uniqueness_percent << ' ' << o.agreement_px << ' ' << o.plane_window_px << ' '
       << o.max_reprojection_px << ' ' << o.max_depth_error << ' ' << o.min_photos << '\n';
  const std::vector<PosedPhoto>& posed = photos.photo_set().photos;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const PinholeCamera& c = posed[i].camera;
    text << posed[i].name << ' ' << fs::file_size(photos.image_path() / posed[i].name) << ' '
         << c.width << ' ' << c.height << ' ' << c.fx << ' ' << c.fy << ' ' << c.cx << ' ' << c.cy
         << ' ' << posed[i].cam_from_world.rotation.coeffs().transpose() << ' '
         << posed[i].cam_from_world.translation.transpose() << ' ' << ranges[i].min << ' '
         << ranges[i].max;
    for (const int j : partners[i]) text << ' ' << j;
    text << '\n';
  }
  return text.str();
}

// Partners, and those that have it as a partner; sorted.
std::vector<std::vector<int>> Witnesses(const std::vector<std::vector<int>>& partners) {
  std::vector<std::set<int>> sets(partners.size());
  for (std::size_t i = 0; i < partners.size(); ++i) {
    for (const int j : partners[i]) {
      sets[i].insert(j);
      sets[static_cast<std::size_t>(j)].insert(static_cast<int>(i));
    }
  }
  std::vector<std::vector<int>> witnesses;
  for (const std::set<int>& set : sets) witnesses.emplace_back(set.begin(), set.end());
  return witnesses;
}

class Builtin {
 public:
  Builtin(const DenseRequest& request, const DenseStereoOptions& options, const JobControl& job)
      : request_(request),
        photos_(*request.photos),
        posed_(photos_.photo_set().photos),
        options_(options),
        job_(job),
        workspace_{request.workspace_path},
        partners_(ChooseStereoPartners(photos_.photo_set(), options)),
        witnesses_(Witnesses(partners_)),
        ranges_(DepthRanges(photos_.photo_set(), request.prior_path)) {}

  OrientedPoints Run() {
    NamePhotosWithoutDepth();
    CheckStamp();
    // Depth maps first: a run that cannot match must not have copied all photos.
    Pass(
        "depth maps", [&](std::size_t i) { return RawPath(i); },
        [&](std::size_t i) { Estimate(i); });
    PrepareDenseWorkspace(photos_, partners_, workspace_, request_.rank, job_);
    Pass(
        "consistency", [&](std::size_t i) { return workspace_.depth_map(posed_[i].name); },
        [&](std::size_t i) { Filter(i); });
    return Fuse();
  }

 private:
  fs::path Folder() const { return request_.workspace_path / "builtin"; }
  fs::path RawPath(std::size_t i) const { return Folder() / (posed_[i].name + ".bin"); }
  bool HasDepth(std::size_t i) const { return !partners_[i].empty() && ranges_[i].IsKnown(); }

  void NamePhotosWithoutDepth() const {
    std::size_t usable = 0;
    for (std::size_t i = 0; i < posed_.size(); ++i) {
      if (HasDepth(i)) {
        ++usable;
      } else {
        job_.Warn(posed_[i].name + ": shares too few points with other photos; it is left out");
      }
    }
    if (usable == 0) {
      throw Error(
          "no photo shares enough points with another one; dense stereo needs a sparse "
          "model with points (run sparse_updater, or `colmap point_triangulator`)");
    }
  }

  void CheckStamp() const {
    const fs::path path = Folder() / "inputs.txt";
    const auto start_again = [&] {
      if (fs::exists(path)) {
        job_.Info("photos, poses or options are not those of the maps in " +
                  request_.workspace_path.string() + "; starting again");
      }
      for (const char* name : {"depth_maps", "normal_maps", "confidence_maps"}) {
        fs::remove_all(workspace_.stereo() / name);
      }
      fs::remove_all(workspace_.images());
      fs::remove_all(Folder());
    };
    AgreeOnStamp(path, Stamp(photos_, partners_, ranges_, options_), start_again, request_.rank,
                 job_);
  }

  // Threads that the memory allows.
  int Concurrency() const {
    double per_photo = 1;
    for (const PosedPhoto& photo : posed_) {
      per_photo = std::max(per_photo, MatchingMemoryMib(photo.camera, options_.num_partners));
    }
    const int cores = std::max(1, tbb::this_task_arena::max_concurrency());
    const int photos = std::clamp(static_cast<int>(options_.max_memory_mib / per_photo), 1, cores);
    job_.Info("matching " + std::to_string(photos) + " photos at a time, about " +
              std::to_string(static_cast<int>(per_photo)) + " MiB each");
    return photos;
  }

  // Makes the files that are missing, and waits for those of the other processes unless only the
  // first one needs them.
  template <typename PathOf, typename Make>
  void Pass(const std::string& name, const PathOf& path_of, const Make& make,
            bool only_first_needs_all = false) const {
    std::vector<std::size_t> missing;
    std::vector<fs::path> paths;
    std::size_t wanted = 0;
    for (std::size_t i = 0; i < posed_.size(); ++i) {
      if (!HasDepth(i)) continue;
      paths.push_back(path_of(i));
      if (!request_.rank.IsMine(i)) continue;
      ++wanted;
      if (!fs::exists(paths.back())) missing.push_back(i);
    }
    MakeMissing(name, missing, wanted, make);
    const bool waits = request_.rank.IsFirst() || !only_first_needs_all;
    if (request_.rank.IsShared() && waits) WaitForFiles(paths, request_.rank, job_);
  }

  template <typename Make>
  void MakeMissing(const std::string& name, const std::vector<std::size_t>& missing,
                   std::size_t wanted, const Make& make) const {
    if (missing.empty()) return;
    const std::size_t there = wanted - missing.size();
    if (there > 0) {
      job_.Info(name + ": " + std::to_string(there) + " of " + std::to_string(wanted) +
                " are there from an earlier run");
    }
    RemainingTime progress(name, there, wanted, job_);
    tbb::task_arena arena(Concurrency());
    arena.execute([&] {
      // Neighbours in the list share partners, and so the system's cache of their files.
      ParallelFor(missing.size(), [&](std::size_t k) {
        if (job_.IsCancelled()) return;
        make(missing[k]);
        progress.Step();
      });
    });
    job_.ThrowIfCancelled();
  }

  StereoView LoadView(std::size_t i) const {
    StereoView view{posed_[i].camera, posed_[i].cam_from_world, cv::Mat()};
    cv::cvtColor(photos_.Load(i), view.gray, cv::COLOR_BGR2GRAY);
    return view;
  }

  void Estimate(std::size_t i) const {
    std::vector<StereoView> partners;
    for (const int j : partners_[i]) partners.push_back(LoadView(static_cast<std::size_t>(j)));
    const MergedDepth depth = EstimateDepth(LoadView(i), partners, ranges_[i], options_);
    WriteDenseMap(MapOf(depth.inverse_depth), RawPath(i));
  }

  DepthView RawView(std::size_t i) const {
    return {posed_[i].camera, posed_[i].cam_from_world, MatOf(ReadDenseMap(RawPath(i)))};
  }

  void Filter(std::size_t i) const {
    std::vector<DepthView> others;
    for (const int j : witnesses_[i]) {
      if (HasDepth(static_cast<std::size_t>(j))) {
        others.push_back(RawView(static_cast<std::size_t>(j)));
      }
    }
    const ConfirmedDepth confirmed = ConfirmDepth(RawView(i), others, options_);
    const PlaneMaps planes = FitPlanes(posed_[i].camera, confirmed.inverse_depth, options_);
    cv::Mat confidence = cv::Mat::zeros(planes.inverse_depth.size(), CV_32F);
    for (int y = 0; y < confidence.rows; ++y) {
      for (int x = 0; x < confidence.cols; ++x) {
        if (!(planes.inverse_depth.at<float>(y, x) > 0)) continue;
        confidence.at<float>(y, x) =
            1 - 1 / static_cast<float>(confirmed.photos.at<unsigned char>(y, x));
      }
    }
    const std::string& name = posed_[i].name;
    WriteDenseMap(MapOf(planes.normal), workspace_.normal_map(name));
    WriteDenseMap(MapOf(confidence), workspace_.confidence_map(name));
    // Last: it says that the photo is done.
    WriteDenseMap(MapOf(Inverted(planes.inverse_depth)), workspace_.depth_map(name));
  }

  FusionView FinalView(std::size_t i, bool only_depth) const {
    const std::string& name = posed_[i].name;
    FusionView view;
    view.photo_index = static_cast<int>(i);
    view.depth = {posed_[i].camera, posed_[i].cam_from_world,
                  Inverted(MatOf(ReadDenseMap(workspace_.depth_map(name))))};
    if (only_depth) return view;
    view.normal = MatOf(ReadDenseMap(workspace_.normal_map(name)));
    const cv::Mat confidence = MatOf(ReadDenseMap(workspace_.confidence_map(name)));
    cv::Mat photos;
    cv::divide(1.0, 1.0 - confidence, photos);
    photos.convertTo(view.photos, CV_8U);
    view.bgr = photos_.Load(i);
    return view;
  }

  OrientedPoints FuseOne(std::size_t i) const {
    std::vector<FusionView> others;
    for (const int j : witnesses_[i]) {
      const auto other = static_cast<std::size_t>(j);
      if (HasDepth(other)) others.push_back(FinalView(other, true));
    }
    OrientedPoints points = FuseView(FinalView(i, false), others, options_);
    if (!request_.region.isEmpty()) {
      std::erase_if(points, [&](const OrientedPoint& point) {
        return !request_.region.contains(point.position);
      });
    }
    points.shrink_to_fit();
    return points;
  }

  OrientedPoints Fuse() const {
    if (request_.rank.IsShared()) return FuseTogether();
    std::vector<OrientedPoints> parts(posed_.size());
    RemainingTime progress("fusion", 0, posed_.size(), job_);
    tbb::task_arena arena(Concurrency());
    arena.execute([&] {
      ParallelFor(posed_.size(), [&](std::size_t i) {
        if (job_.IsCancelled()) return;
        if (HasDepth(i)) parts[i] = FuseOne(i);
        progress.Step();
      });
    });
    job_.ThrowIfCancelled();
    OrientedPoints points;
    for (OrientedPoints& part : parts) {
      points.insert(points.end(), part.begin(), part.end());
      OrientedPoints().swap(part);
    }
    return points;
  }

  // Points of a photo in a file each; the first process puts them together.
  OrientedPoints FuseTogether() const {
    const fs::path folder = Folder() / "fused";
    std::ostringstream stamp;
    stamp << std::hexfloat << options_.fusion_step_px << ' ' << request_.region.min().transpose()
          << ' ' << request_.region.max().transpose() << '\n';
    AgreeOnStamp(
        folder / "inputs.txt", stamp.str(), [&] { fs::remove_all(folder); }, request_.rank, job_);
    const auto path_of = [&](std::size_t i) { return folder / (posed_[i].name + ".bin"); };
    Pass(
        "fusion", path_of, [&](std::size_t i) { WritePointDump(FuseOne(i), path_of(i)); }, true);
    OrientedPoints points;
    if (!request_.rank.IsFirst()) return points;
    for (std::size_t i = 0; i < posed_.size(); ++i) {
      if (HasDepth(i)) AppendPointDump(path_of(i), &points);
    }
    fs::remove_all(folder);
    return points;
  }

  const DenseRequest& request_;
  const PhotoSource& photos_;
  const std::vector<PosedPhoto>& posed_;
  const DenseStereoOptions& options_;
  const JobControl& job_;
  DenseWorkspace workspace_;
  std::vector<std::vector<int>> partners_;
  std::vector<std::vector<int>> witnesses_;
  std::vector<DepthRange> ranges_;
};

}  // namespace

std::vector<DepthRange> DepthRanges(const PhotoSet& photos, const fs::path& prior_path) {
  std::vector<std::vector<float>> depths = DepthsOfPoints(photos);
  std::vector<DepthRange> ranges(depths.size());
  ParallelFor(depths.size(), [&](std::size_t i) {
    if (!prior_path.empty()) {
      AppendDepths(DenseWorkspace{prior_path}.depth_map(photos.photos[i].name), &depths[i]);
    }
    ranges[i] = RangeOfDepths(std::move(depths[i]));
  });
  return ranges;
}

double MatchingMemoryMib(const PinholeCamera& camera, int num_partners) {
  // A pixel: 1 of each photo and 8 of each pair's depth; about 60 of warping and matching.
  const double bytes = 9.0 * num_partners + 60;
  return bytes * camera.width * camera.height / (1024.0 * 1024.0);
}

OrientedPoints ReconstructBuiltin(const DenseRequest& request, const DenseStereoOptions& options,
                                  const JobControl& job) {
  ThrowIfInvalid(options.Check());
  OrientedPoints points = Builtin(request, options, job).Run();
  if (request.rank.IsFirst())
    CheckCloud(points, request.photos->photo_set(), "the built-in stereo");
  return points;
}

}  // namespace colmap_ext
