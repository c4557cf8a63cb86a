#include "colmap_ext/eval/count_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "colmap_ext/geom/ray_scene.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/parallel.h"

namespace colmap_ext {
namespace {

// A surface seen under a flatter angle than this shows nothing that could be matched.
constexpr double kMinFacingCosine = 0.17364817766693033;  // cos 80 degrees

// Rays end this share of their length before the surface: truth meshes are exact, but RayScene
// works in float32.
constexpr double kEpsilonShare = 1e-4;

struct TruthView {
  Rigid3d cam_from_truth;
  Eigen::Vector3d center_in_truth;
  const Camera* camera;
  double max_radius;  // of normalised coordinates inside the photo
};

// Distortion polynomials fold over far outside the photo: only what lies within the corners is
// projected.
double CornerRadius(const Camera& camera) {
  double radius = 0;
  for (const double x : {0.0, static_cast<double>(camera.width)}) {
    for (const double y : {0.0, static_cast<double>(camera.height)}) {
      const auto corner = NormalizedFromImage(camera, {x, y});
      if (!corner) return std::numeric_limits<double>::infinity();
      radius = std::max(radius, corner->norm());
    }
  }
  return radius;
}

bool ProjectsInto(const TruthView& view, const Eigen::Vector3d& point_in_truth) {
  const Eigen::Vector3d in_cam = view.cam_from_truth * point_in_truth;
  if (in_cam.z() <= 0) return false;
  const Eigen::Vector2d normalized = in_cam.hnormalized();
  if (normalized.norm() > view.max_radius) return false;
  const Eigen::Vector2d pixel = ImageFromNormalized(*view.camera, normalized);
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= view.camera->width &&
         pixel.y() <= view.camera->height;
}

bool Sees(const TruthView& view, const SurfaceSample& sample, const RayScene& scene) {
  const Eigen::Vector3d to_camera = view.center_in_truth - sample.position;
  const double distance = to_camera.norm();
  if (to_camera.dot(sample.normal) < kMinFacingCosine * distance) return false;
  if (!ProjectsInto(view, sample.position)) return false;
  return !scene.IsOccluded(view.center_in_truth, sample.position, kEpsilonShare * distance);
}

std::vector<TruthView> ViewsOf(const Reconstruction& model, const Sim3d& truth_from_model) {
  std::vector<TruthView> views;
  for (const auto& [id, image] : model.images) {
    const Rigid3d cam_from_truth = TransformCameraWorld(truth_from_model, image.cam_from_world);
    const Camera& camera = model.cameras.at(image.camera_id);
    views.push_back({cam_from_truth, CameraCenter(cam_from_truth), &camera, CornerRadius(camera)});
  }
  return views;
}

}  // namespace

std::vector<int> CountViews(const std::vector<SurfaceSample>& samples, const TriangleMesh& truth,
                            const Reconstruction& model, const Sim3d& truth_from_model,
                            const JobControl& job) {
  if (truth.faces.empty()) throw Error("counting views: the ground truth has no faces");
  const std::vector<TruthView> views = ViewsOf(model, truth_from_model);
  const RayScene scene(truth);
  std::vector<int> num_views(samples.size(), 0);
  ParallelFor(samples.size(), [&](std::size_t i) {
    job.ThrowIfCancelled();
    for (const TruthView& view : views) num_views[i] += Sees(view, samples[i], scene) ? 1 : 0;
  });
  return num_views;
}

}  // namespace colmap_ext
