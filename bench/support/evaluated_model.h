// A model compared with the truth as the paper does.
#pragma once

#include <filesystem>

#include "colmap_ext/eval/evaluate.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

struct EvaluatedModel {
  EvaluationResult result;  // `seen`: by two photos of the model or more
  TriangleMesh aligned;     // the model in the truth's frame
};

// `align`: by the true centres of its photos (`true_poses`), then ICP; else the model is compared
// as it is. `sparse`: the COLMAP model whose photos made it.
EvaluatedModel EvaluateAgainst(const TriangleMesh& truth, const std::filesystem::path& mesh,
                               const std::filesystem::path& sparse,
                               const std::filesystem::path& true_poses, bool align,
                               const JobControl& job);

}  // namespace colmap_ext
