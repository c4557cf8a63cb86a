#include "evaluated_model.h"

#include "colmap_ext/eval/alignment.h"
#include "colmap_ext/eval/count_views.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"

namespace colmap_ext {

EvaluatedModel EvaluateAgainst(const TriangleMesh& truth, const std::filesystem::path& mesh,
                               const std::filesystem::path& sparse,
                               const std::filesystem::path& true_poses, bool align,
                               const JobControl& job) {
  const EvaluationOptions options;
  const Reconstruction model = ReadReconstruction(sparse);
  const TriangleMesh reconstructed = ReadMesh(mesh);
  Sim3d truth_from_model;
  if (align) {
    const auto pairs = PairCameras(model, PoseOfPhoto(ReadTruePoses(true_poses)));
    truth_from_model = AlignModel(reconstructed, truth, pairs, options, job).truth_from_model;
  }
  EvaluatedModel evaluated;
  evaluated.aligned = TransformMesh(truth_from_model, reconstructed);
  evaluated.result = EvaluateModel(evaluated.aligned, truth, options, job);
  SplitBySeen(CountViews(evaluated.result.truth_samples, truth, model, truth_from_model, job),
              options, &evaluated.result);
  return evaluated;
}

}  // namespace colmap_ext
