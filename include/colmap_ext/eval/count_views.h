// Which surfaces of the truth the photos can see at all: what they do not show is no error of a
// reconstruction.
#pragma once

#include <vector>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Number of photos of `model` that see each sample: it projects into the photo, its face looks
// towards the camera within 80 degrees of its normal, and nothing of `truth` lies between.
// `truth_from_model` moves the cameras into the frame of the truth. Throws Error when the truth has
// no faces (a cloud hides nothing).
std::vector<int> CountViews(const std::vector<SurfaceSample>& samples, const TriangleMesh& truth,
                            const Reconstruction& model, const Sim3d& truth_from_model,
                            const JobControl& job);

}  // namespace colmap_ext
