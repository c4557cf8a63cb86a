#include "sub_model.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "update_database.h"

namespace colmap_ext {
namespace {

// Photos beyond those matched: they hold points that the others see too weakly.
constexpr std::size_t kMarginPhotos = 12;

using Links = std::map<ImageId, std::set<ImageId>>;

// Pairs that the mapper would use.
Links LinksOf(const std::map<ImagePair, TwoViewSummary>& pairs) {
  Links links;
  for (const auto& [pair, summary] : pairs) {
    if (summary.num_inliers < kMinInliers) continue;
    links[pair.first].insert(pair.second);
    links[pair.second].insert(pair.first);
  }
  return links;
}

// Registered photos that share most points with those of the scope, best first.
std::vector<ImageId> CovisiblePhotos(const Reconstruction& model, const std::set<ImageId>& scope) {
  std::set<Point3DId> points;
  for (const ImageId id : scope) {
    for (const Keypoint2D& keypoint : model.images.at(id).keypoints) {
      if (keypoint.point3D_id != kInvalidPoint3DId) points.insert(keypoint.point3D_id);
    }
  }
  std::map<ImageId, int> shared;
  for (const Point3DId id : points) {
    for (const TrackElement& element : model.points.at(id).track) {
      if (scope.count(element.image_id) == 0) ++shared[element.image_id];
    }
  }
  std::vector<std::pair<int, ImageId>> order;
  for (const auto& [id, count] : shared) order.emplace_back(-count, id);
  std::sort(order.begin(), order.end());
  std::vector<ImageId> photos;
  for (const auto& [count, id] : order) photos.push_back(id);
  return photos;
}

bool HasLinkInto(const Links& links, ImageId id, const std::set<ImageId>& scope) {
  const auto found = links.find(id);
  return found != links.end() && std::any_of(found->second.begin(), found->second.end(),
                                             [&](ImageId other) { return scope.count(other) > 0; });
}

// Which point of the model a keypoint belongs to.
Point3DId PointAt(const Reconstruction& model, const TrackElement& element) {
  return model.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id;
}

bool SameTrack(std::vector<TrackElement> a, std::vector<TrackElement> b) {
  const auto key = [](const TrackElement& e) { return std::pair(e.image_id, e.keypoint_index); };
  const auto less = [&](const TrackElement& x, const TrackElement& y) { return key(x) < key(y); };
  const auto same = [&](const TrackElement& x, const TrackElement& y) { return key(x) == key(y); };
  std::sort(a.begin(), a.end(), less);
  std::sort(b.begin(), b.end(), less);
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

// One merge: the steps share these.
class Merger {
 public:
  Merger(const Reconstruction& before, const Reconstruction& after, Reconstruction* model)
      : before_(before), after_(after), model_(*model) {}

  MergedPart Run() {
    AddImages();
    for (const auto& [id, point] : after_.points) ClaimParents(id, point);
    TakeOut();
    for (const auto& [id, point] : after_.points) PutBack(id, point);
    for (const auto& [id, point] : old_) RestoreUnclaimed(id, point);
    return std::move(result_);
  }

 private:
  void AddImages() {
    for (const auto& [id, image] : after_.images) {
      if (model_.images.count(id) > 0) continue;
      SparseImage& added = model_.images.emplace(id, image).first->second;
      for (Keypoint2D& keypoint : added.keypoints) keypoint.point3D_id = kInvalidPoint3DId;
      model_.cameras.emplace(image.camera_id, after_.cameras.at(image.camera_id));
      result_.new_images.insert(id);
    }
  }

  // The points of the model whose observations `point` has now; the first one to ask gets each.
  void ClaimParents(Point3DId id, const SparsePoint& point) {
    std::set<Point3DId> parents;
    for (const TrackElement& element : point.track) {
      const Point3DId parent = PointAt(model_, element);
      if (parent == kInvalidPoint3DId || !claimed_.insert(parent).second) continue;
      parents.insert(parent);
    }
    parents_[id] = parents;
  }

  // Removes the points that may change, remembering them: those of the part, and those claimed.
  void TakeOut() {
    std::set<Point3DId> ids = claimed_;
    for (const auto& [id, point] : before_.points) ids.insert(id);
    next_id_ = model_.points.empty() ? 1 : model_.points.rbegin()->first + 1;
    for (const Point3DId id : ids) {
      const auto found = model_.points.find(id);
      for (const TrackElement& element : found->second.track) {
        Slot(element) = kInvalidPoint3DId;
      }
      old_[id] = std::move(found->second);
      model_.points.erase(found);
    }
  }

  Point3DId& Slot(const TrackElement& element) {
    return model_.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id;
  }

  // Seen by a photo that the part did not have, or one whose points it was too small to hold.
  bool IsOutside(Point3DId id, const TrackElement& element) const {
    return before_.images.count(element.image_id) == 0 || before_.points.count(id) == 0;
  }

  void PutBack(Point3DId id, const SparsePoint& point) {
    const std::set<Point3DId>& parents = parents_.at(id);
    std::vector<TrackElement> track = point.track;
    std::set<ImageId> photos;
    for (const TrackElement& element : track) photos.insert(element.image_id);
    for (const Point3DId parent : parents) {
      for (const TrackElement& element : old_.at(parent).track) {
        if (IsOutside(parent, element) && photos.insert(element.image_id).second) {
          track.push_back(element);
        }
      }
    }
    Point3DId target = 0;
    if (parents.empty()) {
      target = next_id_++;
    } else {
      target = parents.count(id) > 0 ? id : *parents.begin();
    }
    Store(target, parents.empty() ? point : Updated(old_.at(target), point, track), track);
  }

  // The old point where its photos are the same or mostly outside of the part, else the new place.
  SparsePoint Updated(const SparsePoint& old, const SparsePoint& now,
                      const std::vector<TrackElement>& track) const {
    SparsePoint point = old;
    const bool mostly_outside = 2 * now.track.size() < track.size();
    if (!SameTrack(old.track, track) && !mostly_outside) {
      point.position = now.position;
      point.error_px = now.error_px;
    }
    return point;
  }

  void Store(Point3DId id, SparsePoint point, std::vector<TrackElement> track) {
    const auto old = old_.find(id);
    const bool same = old != old_.end() && SameTrack(old->second.track, track);
    if (!same) result_.changed_points.insert(id);
    point.track = same ? old->second.track : std::move(track);
    for (const TrackElement& element : point.track) Slot(element) = id;
    model_.points[id] = std::move(point);
  }

  // A point that the part lost: it lives on where the rest of the model sees it.
  void RestoreUnclaimed(Point3DId id, const SparsePoint& point) {
    if (claimed_.count(id) > 0) return;
    std::vector<TrackElement> track;
    std::size_t outside = 0;
    for (const TrackElement& element : point.track) {
      if (PointAt(model_, element) != kInvalidPoint3DId) continue;
      track.push_back(element);
      outside += IsOutside(id, element) ? 1 : 0;
    }
    if (outside >= 2) Store(id, point, track);
  }

  const Reconstruction& before_;
  const Reconstruction& after_;
  Reconstruction& model_;
  MergedPart result_;
  std::map<Point3DId, std::set<Point3DId>> parents_;  // of the points of `after_`
  std::set<Point3DId> claimed_;
  std::map<Point3DId, SparsePoint> old_;
  Point3DId next_id_ = 1;
};

}  // namespace

UpdateScope ChooseScope(const Reconstruction& model,
                        const std::map<ImagePair, TwoViewSummary>& pairs,
                        const std::set<ImageId>& untried) {
  const Links links = LinksOf(pairs);
  UpdateScope scope;
  std::vector<ImageId> queue(untried.begin(), untried.end());
  while (!queue.empty()) {
    const ImageId id = queue.back();
    queue.pop_back();
    const auto found = links.find(id);
    if (found == links.end() || !scope.missing.insert(id).second) continue;
    for (const ImageId other : found->second) {
      if (model.images.count(other) > 0) {
        scope.registered.insert(other);
      } else {
        queue.push_back(other);
      }
    }
  }
  if (scope.registered.empty()) return scope;
  std::set<ImageId> all = scope.registered;
  std::size_t margin = 0;
  for (const ImageId id : CovisiblePhotos(model, scope.registered)) {
    if (margin == kMarginPhotos) break;
    if (!HasLinkInto(links, id, scope.registered)) continue;
    all.insert(id);
    ++margin;
  }
  scope.registered = std::move(all);
  return scope;
}

Reconstruction SubModel(const Reconstruction& model, const std::set<ImageId>& images) {
  Reconstruction part;
  std::map<Point3DId, std::vector<TrackElement>> tracks;
  for (const ImageId id : images) {
    SparseImage& image = part.images.emplace(id, model.images.at(id)).first->second;
    part.cameras.emplace(image.camera_id, model.cameras.at(image.camera_id));
    for (std::uint32_t k = 0; k < image.keypoints.size(); ++k) {
      const Point3DId point = image.keypoints[k].point3D_id;
      if (point != kInvalidPoint3DId) tracks[point].push_back({id, k});
    }
  }
  for (auto& [id, track] : tracks) {
    std::set<ImageId> photos;
    for (const TrackElement& element : track) photos.insert(element.image_id);
    if (photos.size() < 2) {
      for (const TrackElement& element : track) {
        part.images.at(element.image_id).keypoints[element.keypoint_index].point3D_id =
            kInvalidPoint3DId;
      }
      continue;
    }
    SparsePoint& point = part.points[id];
    point = model.points.at(id);
    point.track = std::move(track);
  }
  return part;
}

MergedPart MergeSubModel(const Reconstruction& before, const Reconstruction& after,
                         Reconstruction* model) {
  return Merger(before, after, model).Run();
}

}  // namespace colmap_ext
