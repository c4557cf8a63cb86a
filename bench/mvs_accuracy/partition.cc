#include "partition.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/slic.hpp>

#include "colmap_ext/mvs/view_lookup.h"
#include "colmap_ext/util/stage_timer.h"

namespace colmap_ext {
namespace {

cv::Mat1b TrueBoundaries(const ViewTruth& truth) {
  constexpr float kJump = 0.05F;
  constexpr float kCrease = 1e-3F;
  cv::Mat1b boundary(truth.depth.size(), static_cast<std::uint8_t>(0));
  for (int y = 1; y + 1 < boundary.rows; ++y) {
    for (int x = 1; x + 1 < boundary.cols; ++x) {
      const float depth = truth.depth(y, x);
      if (truth.model(y, x) == 0 || !(depth > 0)) continue;
      for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
        const float before = truth.depth(y - dy, x - dx);
        const float after = truth.depth(y + dy, x + dx);
        const auto jumps = [&](float other) { return !(other < (1 + kJump) * depth); };
        const float turn = std::abs(depth / before - 2 + depth / after);
        if (jumps(before) || jumps(after) || turn > kCrease) boundary(y, x) = 1;
      }
    }
  }
  return boundary;
}

// Pixels whose right or lower neighbour has another label.
cv::Mat1b LabelBoundaries(const cv::Mat1i& labels) {
  cv::Mat1b boundary(labels.size(), static_cast<std::uint8_t>(0));
  for (int y = 0; y + 1 < labels.rows; ++y) {
    for (int x = 0; x + 1 < labels.cols; ++x) {
      boundary(y, x) = labels(y, x) != labels(y, x + 1) || labels(y, x) != labels(y + 1, x);
    }
  }
  return boundary;
}

struct Figures {
  double cpu_s = 0, superpixels = 0, truth = 0, recalled = 0, on_boundary = 0, pixels = 0;

  void Count(const cv::Mat1i& labels, const cv::Mat1b& true_boundary) {
    const cv::Mat1b boundary = LabelBoundaries(labels);
    cv::Mat1b near;
    cv::dilate(boundary, near, cv::Mat1b::ones(5, 5));
    truth += cv::countNonZero(true_boundary);
    recalled += cv::countNonZero(near & true_boundary);
    on_boundary += cv::countNonZero(boundary);
    pixels += static_cast<double>(boundary.total());
  }
};

cv::Mat1i OurLabels(const PosedPhoto& photo, const ImageMesh& mesh) {
  ViewMesh view;
  view.camera = photo.camera;
  view.image = mesh;
  cv::Mat1i labels = TriangleIdMap(view);
  for (int& label : labels) {
    if (label >= 0) label = mesh.superpixel[static_cast<std::size_t>(label)];
  }
  return labels;
}

cv::Mat1i SlicLabels(const cv::Mat& bgr, int count, Figures* figures) {
  constexpr float kCompactness = 10.0F;
  constexpr int kIterations = 10;
  const StageTimer timer;
  cv::Mat lab, labels;
  cv::cvtColor(bgr, lab, cv::COLOR_BGR2Lab);
  const int size = std::max(
      2, static_cast<int>(std::lround(std::sqrt(static_cast<double>(bgr.total()) / count))));
  const auto slic = cv::ximgproc::createSuperpixelSLIC(lab, cv::ximgproc::SLIC, size, kCompactness);
  slic->iterate(kIterations);
  slic->enforceLabelConnectivity(25);  // %, OpenCV's default
  slic->getLabels(labels);
  figures->cpu_s += timer.Stop().cpu_s;
  figures->superpixels += slic->getNumberOfSuperpixels();
  return labels;
}

void AddRows(const std::string& name, const Figures& figures, double photos, BenchReport* report) {
  report->Add(name + ": superpixels", figures.superpixels / photos, "a photo");
  report->Add(name + ": CPU", 1000 * figures.cpu_s / photos, "ms a photo");
  report->Add(name + ": true boundaries recalled",
              100 * figures.recalled / std::max(1.0, figures.truth), "%");
  report->Add(name + ": pixels on boundaries", 100 * figures.on_boundary / figures.pixels, "%");
}

}  // namespace

void ReportPartition(const std::string& name, const Survey& survey,
                     const SuperpixelOptions& options, int every, BenchReport* report) {
  Figures ours, slic;
  double photos = 0;
  for (std::size_t i = 0; i < survey.photos.photos.size(); i += static_cast<std::size_t>(every)) {
    const PosedPhoto& photo = survey.photos.photos[i];
    const cv::Mat1b truth = TrueBoundaries(survey.truth[i]);
    const StageTimer timer;
    const ImageMesh mesh = SegmentPhoto(photo.bgr, options);
    ours.cpu_s += timer.Stop().cpu_s;
    ours.superpixels += mesh.num_superpixels;
    ours.Count(OurLabels(photo, mesh), truth);
    slic.Count(SlicLabels(photo.bgr, mesh.num_superpixels, &slic), truth);
    photos += 1;
  }
  AddRows(name + ", our polygons", ours, photos, report);
  AddRows(name + ", SLIC", slic, photos, report);
}

}  // namespace colmap_ext
