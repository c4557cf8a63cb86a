#include "matcher_race.h"

#include <cmath>
#include <functional>
#include <opencv2/features2d.hpp>
#include <set>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/util/stage_timer.h"
#include "sfm/descriptor_kernel.h"

namespace colmap_ext {
namespace {

struct Race {
  std::vector<DescriptorMatrix> photos;
  std::vector<PhotoPair> pairs;
};

// Pairs among the first photos of the database.
Race ReadRace(const std::filesystem::path& database_path) {
  constexpr std::size_t kPairs = 100;
  const Database database = Database::Open(database_path, Database::Access::kReadOnly);
  std::map<ImageId, int> index;
  Race race;
  for (const auto& [pair, count] : database.NumMatches()) {
    if (race.pairs.size() == kPairs) break;
    for (const ImageId id : {pair.first, pair.second}) {
      if (!index.emplace(id, static_cast<int>(race.photos.size())).second) continue;
      race.photos.push_back(database.ReadDescriptors(id));
    }
    race.pairs.emplace_back(index.at(pair.first), index.at(pair.second));
  }
  return race;
}

void Measure(const std::string& name, const Race& race, BenchReport* report,
             const std::function<std::size_t(int, int)>& match) {
  const StageTimer timer;
  std::size_t matches = 0;
  for (const auto& [a, b] : race.pairs) matches += match(a, b);
  const auto pairs = static_cast<double>(race.pairs.size());
  report->Add("matcher " + name, 1000 * timer.Stop().cpu_s / pairs, "CPU ms a pair");
  report->Add("matcher " + name + ": matches", static_cast<double>(matches) / pairs, "a pair");
}

const char* NameOf(CpuPath path) {
  switch (path) {
    case CpuPath::kPortable:
      return "ours, portable";
    case CpuPath::kSse2:
      return "ours, SSE2";
    case CpuPath::kAvx2:
      return "ours, AVX2";
    case CpuPath::kAvx512Vnni:
      return "ours, AVX-512 VNNI";
  }
  return "";
}

// Matches by OpenCV with the ratio test on angles and the cross check.
std::size_t MatchByOpenCv(cv::DescriptorMatcher& matcher, const cv::Mat& first,
                          const cv::Mat& second, const MatchingOptions& options) {
  const auto best = [&](const cv::Mat& query, const cv::Mat& train) {
    std::vector<std::vector<cv::DMatch>> found;
    matcher.knnMatch(query, train, found, 2);
    std::vector<int> index(static_cast<std::size_t>(query.rows), -1);
    const auto angle = [](float distance) { return 2 * std::asin(distance / 1024.0); };
    for (const auto& two : found) {
      if (two.size() < 2 || angle(two[0].distance) > options.max_distance ||
          angle(two[0].distance) >= options.max_ratio * angle(two[1].distance)) {
        continue;
      }
      index[static_cast<std::size_t>(two[0].queryIdx)] = two[0].trainIdx;
    }
    return index;
  };
  const std::vector<int> forward = best(first, second), backward = best(second, first);
  std::size_t matches = 0;
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const int j = forward[i];
    matches += j >= 0 && backward[static_cast<std::size_t>(j)] == static_cast<int>(i);
  }
  return matches;
}

}  // namespace

void RaceMatchers(const std::filesystem::path& database_path, const MatchingOptions& options,
                  BenchReport* report) {
  const Race race = ReadRace(database_path);
  std::vector<DescriptorView> views;
  std::vector<cv::Mat> floats;
  double features = 0;
  for (const DescriptorMatrix& photo : race.photos) {
    views.push_back({photo.data(), static_cast<int>(photo.rows())});
    const cv::Mat bytes(static_cast<int>(photo.rows()), kDescriptorSize, CV_8U,
                        const_cast<std::uint8_t*>(photo.data()));
    floats.emplace_back();
    bytes.convertTo(floats.back(), CV_32F);
    features += static_cast<double>(photo.rows());
  }
  report->Add("matchers: features", features / static_cast<double>(views.size()), "a photo");
  for (const CpuPath path : AvailableCpuPaths()) {
    Measure(NameOf(path), race, report, [&](int a, int b) {
      return MatchDescriptorsOn(path, views[static_cast<std::size_t>(a)],
                                views[static_cast<std::size_t>(b)], options)
          .size();
    });
  }
  cv::setNumThreads(1);
  for (const char* name : {"BruteForce", "FlannBased"}) {
    const cv::Ptr<cv::DescriptorMatcher> matcher = cv::DescriptorMatcher::create(name);
    Measure(std::string("OpenCV, ") + name, race, report, [&](int a, int b) {
      return MatchByOpenCv(*matcher, floats[static_cast<std::size_t>(a)],
                           floats[static_cast<std::size_t>(b)], options);
    });
  }
}

}  // namespace colmap_ext
