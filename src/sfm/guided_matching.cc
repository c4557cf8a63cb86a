#include "guided_matching.h"

#include <algorithm>
#include <cstdint>

#include "colmap_ext/util/error.h"
#include "descriptor_kernel.h"

namespace colmap_ext {
namespace {

// Epipolar lines in one photo of the other one's keypoints: a x + b y + c = 0 with a² + b² = 1.
Eigen::Matrix3Xf LinesOf(const Eigen::Matrix2Xf& points, const Eigen::Matrix3d& matrix) {
  Eigen::Matrix3Xf lines = matrix.cast<float>() * points.colwise().homogeneous();
  for (Eigen::Index k = 0; k < lines.cols(); ++k) {
    const float length = lines.col(k).head<2>().norm();
    if (length > 0) lines.col(k) /= length;
  }
  return lines;
}

std::int32_t Dot(const std::uint8_t* a, const std::uint8_t* b) {
  std::int32_t sum = 0;
  for (int k = 0; k < kDescriptorSize; ++k) sum += std::int32_t{a[k]} * std::int32_t{b[k]};
  return sum;
}

// Keypoints of one photo, and the lines in it of the other one's.
struct Side {
  const GuidedPhoto& photo;
  Eigen::Matrix3Xf lines;
  std::vector<bool> has_match;
};

// The best two partners in `to` of keypoint `i` of `from`.
BestTwo BestOnLine(const Side& from, const Side& to, Eigen::Index i, Eigen::ArrayXf* distances) {
  const Eigen::Vector3f line = to.lines.col(i);
  *distances =
      (line.x() * to.photo.points.row(0) + line.y() * to.photo.points.row(1)).transpose().array() +
      line.z();
  const Eigen::Vector3f point = from.photo.points.col(i).homogeneous();
  const std::uint8_t* descriptor = from.photo.descriptors.bytes + i * kDescriptorSize;
  BestTwo best;
  for (Eigen::Index j = 0; j < distances->size(); ++j) {
    if (!(std::abs((*distances)[j]) <= to.photo.max_error)) continue;
    if (!(std::abs(from.lines.col(j).dot(point)) <= from.photo.max_error)) continue;
    const std::int32_t dot = Dot(descriptor, to.photo.descriptors.bytes + j * kDescriptorSize);
    if (dot > best.best) {
      best = {dot, best.best, static_cast<std::int32_t>(j)};
    } else if (dot > best.second) {
      best.second = dot;
    }
  }
  return best;
}

// Partner of each keypoint of `from` that has no match yet, -1 for none.
std::vector<std::int32_t> PartnersOf(const Side& from, const Side& to,
                                     const MatchingOptions& options) {
  std::vector<std::int32_t> partners(from.has_match.size(), -1);
  Eigen::ArrayXf distances;
  for (std::size_t i = 0; i < partners.size(); ++i) {
    if (from.has_match[i]) continue;
    partners[i] =
        AcceptedMatch(BestOnLine(from, to, static_cast<Eigen::Index>(i), &distances), options);
  }
  return partners;
}

}  // namespace

std::vector<KeypointMatch> AddGuidedMatches(const GuidedPhoto& first, const GuidedPhoto& second,
                                            const Eigen::Matrix3d& matrix,
                                            const std::vector<KeypointMatch>& matches,
                                            const MatchingOptions& options) {
  ThrowIfInvalid(options.Check());
  Side a = {first, LinesOf(second.points, matrix.transpose()),
            std::vector<bool>(static_cast<std::size_t>(first.points.cols()))};
  Side b = {second, LinesOf(first.points, matrix),
            std::vector<bool>(static_cast<std::size_t>(second.points.cols()))};
  for (const KeypointMatch& match : matches) {
    a.has_match.at(match.first) = true;
    b.has_match.at(match.second) = true;
  }
  const std::vector<std::int32_t> partner_of_first = PartnersOf(a, b, options);
  const std::vector<std::int32_t> partner_of_second = PartnersOf(b, a, options);
  std::vector<KeypointMatch> all = matches;
  for (std::size_t i = 0; i < partner_of_first.size(); ++i) {
    const std::int32_t j = partner_of_first[i];
    if (j < 0) continue;
    if (partner_of_second[static_cast<std::size_t>(j)] != static_cast<std::int32_t>(i)) continue;
    all.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace colmap_ext
