#include "colmap_ext/dense/back_end.h"

#include "colmap_ext/dense/builtin.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

constexpr std::size_t kMinPoints = 100;
constexpr double kMarginShare = 0.05;  // of the width, around a photo

class BuiltinBackEnd : public DenseBackEnd {
 public:
  explicit BuiltinBackEnd(const DenseStereoOptions& options) : options_(options) {}
  std::string Name() const override { return "builtin"; }
  std::string WhyUnavailable() const override { return ""; }
  OrientedPoints Reconstruct(const DenseRequest& request, const JobControl& job) override {
    return ReconstructBuiltin(request, options_, job);
  }

 private:
  DenseStereoOptions options_;
};

bool IsSeen(const Eigen::Vector3d& position, const PhotoSet& photos) {
  for (const PosedPhoto& photo : photos.photos) {
    const Eigen::Vector3d in_cam = photo.cam_from_world * position;
    if (in_cam.z() > 0 &&
        photo.camera.Contains(photo.camera.Project(in_cam), -kMarginShare * photo.camera.width)) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::unique_ptr<DenseBackEnd> MakeBuiltinBackEnd(const DenseStereoOptions& options) {
  return std::make_unique<BuiltinBackEnd>(options);
}

DenseBackEnd& ChooseBackEnd(const std::string& name,
                            const std::vector<std::unique_ptr<DenseBackEnd>>& back_ends) {
  std::string names = "auto";
  std::string reasons;
  for (const std::unique_ptr<DenseBackEnd>& back_end : back_ends) {
    names += ", " + back_end->Name();
    if (name != "auto" && name != back_end->Name()) continue;
    const std::string reason = back_end->WhyUnavailable();
    if (reason.empty()) return *back_end;
    if (name != "auto") throw Error("back end " + name + " cannot be used: " + reason);
    reasons += (reasons.empty() ? "" : "; ") + back_end->Name() + ": " + reason;
  }
  if (name == "auto") throw Error("no dense back end can be used: " + reasons);
  throw UsageError("--backend " + name + ": there is no such back end; give one of " + names);
}

void CheckCloud(const OrientedPoints& points, const PhotoSet& photos, const std::string& producer) {
  if (points.size() < kMinPoints) {
    throw Error(producer + " gave only " + std::to_string(points.size()) +
                " points; do the photos overlap, and is the region of interest right?");
  }
  const std::size_t step = points.size() / 1000 + 1;
  std::size_t asked = 0, seen = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].position.allFinite() || !points[i].normal.allFinite()) {
      throw Error(producer + " gave a point that is not finite (number " + std::to_string(i) + ")");
    }
    if (i % step != 0) continue;
    ++asked;
    seen += IsSeen(points[i].position, photos) ? 1U : 0U;
  }
  if (2 * seen < asked) {
    throw Error(producer + " gave a cloud that lies outside of the photos: only " +
                std::to_string(100 * seen / asked) + " % of its points are in view of one");
  }
}

}  // namespace colmap_ext
