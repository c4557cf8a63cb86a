#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "colmap_ext/flight/picture_source.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDigits = 15;

std::optional<std::int64_t> NumberIn(const std::string& name) {
  const auto is_digit = [](char letter) { return letter >= '0' && letter <= '9'; };
  const auto last = std::find_if(name.rbegin(), name.rend(), is_digit);
  const auto first = std::find_if_not(last, name.rend(), is_digit);
  const std::string digits(first.base(), last.base());
  if (digits.empty() || digits.size() > kMaxDigits) return std::nullopt;
  return std::stoll(digits);
}

struct Pair {
  double apart_s;
  std::size_t capture;
  std::size_t file;
};

// Pairs of a capture and a file whose times fit, nearest first.
std::vector<Pair> FittingPairs(const std::vector<ReportedCapture>& captures,
                               const std::vector<CaptureFile>& files,
                               const CaptureFolderOptions& options) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < captures.size(); ++i) {
    for (std::size_t k = 0; k < files.size(); ++k) {
      const double apart_s =
          std::abs(files[k].time_s + options.clock_offset_s - captures[i].time_s);
      if (apart_s <= options.tolerance_s) pairs.push_back({apart_s, i, k});
    }
  }
  std::ranges::sort(pairs, {}, [](const Pair& pair) {
    return std::tuple(pair.apart_s, pair.capture, pair.file);
  });
  return pairs;
}

// The distance from index to number that most captures agree on; of equals the one whose times fit
// best.
std::optional<std::int64_t> CommonDistance(const std::vector<ReportedCapture>& captures,
                                           const std::vector<CaptureFile>& files,
                                           const std::vector<Pair>& pairs) {
  struct Votes {
    std::set<std::size_t> captures;
    double apart_s = 0;
  };
  std::map<std::int64_t, Votes> votes;
  for (const Pair& pair : pairs) {
    if (!files[pair.file].number) continue;
    Votes& vote = votes[*files[pair.file].number - captures[pair.capture].index];
    vote.captures.insert(pair.capture);
    vote.apart_s += pair.apart_s;
  }
  const auto is_better = [](const auto& a, const auto& b) {
    const std::size_t a_count = a.second.captures.size();
    const std::size_t b_count = b.second.captures.size();
    return a_count != b_count ? a_count > b_count : a.second.apart_s < b.second.apart_s;
  };
  const auto best = std::min_element(votes.begin(), votes.end(), is_better);
  if (best == votes.end()) return std::nullopt;
  return best->first;
}

}  // namespace

std::string CaptureFolderOptions::Check() const {
  if (!(tolerance_s > 0 && tolerance_s <= 3600)) return "pictures: tolerance_s is not in 0 … 3600";
  if (!(std::abs(clock_offset_s) <= 1e9)) return "pictures: clock_offset_s is not in ±1e9";
  if (!(settle_s >= 0 && settle_s <= 3600)) return "pictures: settle_s is not in 0 … 3600";
  return "";
}

std::vector<CaptureFile> ListCaptureFiles(const fs::path& folder,
                                          const CaptureFolderOptions& options, double now_unix_s) {
  ThrowIfInvalid(options.Check());
  std::vector<CaptureFile> files;
  if (!fs::is_directory(folder)) return files;
  for (const std::string& name : ListPhotos(folder)) {
    const fs::path path = folder / name;
    struct stat status {};
    // A file may be gone again since it was listed.
    if (stat(path.c_str(), &status) != 0 || status.st_size == 0) continue;
    const double time_s = static_cast<double>(status.st_mtim.tv_sec) +
                          1e-9 * static_cast<double>(status.st_mtim.tv_nsec);
    const double changed_s = static_cast<double>(status.st_ctim.tv_sec) +
                             1e-9 * static_cast<double>(status.st_ctim.tv_nsec);
    if (now_unix_s - std::max(time_s, changed_s) < options.settle_s) continue;
    files.push_back({path, time_s, NumberIn(path.stem().string())});
  }
  return files;
}

std::vector<std::optional<std::size_t>> MatchCaptureFiles(
    const std::vector<ReportedCapture>& captures, const std::vector<CaptureFile>& files,
    const CaptureFolderOptions& options) {
  ThrowIfInvalid(options.Check());
  std::vector<std::optional<std::size_t>> match(captures.size());
  std::vector<bool> is_taken(files.size(), false);
  const std::vector<Pair> pairs = FittingPairs(captures, files, options);
  const auto take = [&](const Pair& pair) {
    if (match[pair.capture] || is_taken[pair.file]) return;
    match[pair.capture] = pair.file;
    is_taken[pair.file] = true;
  };
  if (const auto distance = CommonDistance(captures, files, pairs)) {
    for (const Pair& pair : pairs) {
      if (files[pair.file].number == captures[pair.capture].index + *distance) take(pair);
    }
  }
  // By time alone: both ways, no other may come near.
  constexpr double kNextBest = 2;
  const auto is_clear = [&](const Pair& pair) {
    return std::ranges::none_of(pairs, [&](const Pair& other) {
      const bool rivals = (other.capture == pair.capture) != (other.file == pair.file);
      return rivals && !is_taken[other.file] && !match[other.capture] &&
             other.apart_s < kNextBest * pair.apart_s;
    });
  };
  for (const Pair& pair : pairs) {
    if (!files[pair.file].number && is_clear(pair)) take(pair);
  }
  return match;
}

}  // namespace colmap_ext
