// Depths of superpixel stereo against the truth.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "colmap_ext/scene/view_mesh.h"
#include "survey.h"

namespace colmap_ext {

// Over the pixels (every `step`-th in both directions) whose ray hits the model. Errors are
// |Δz| / z, at most 1; a pixel without positive depth has error 1.
struct AccuracyFigures {
  double share_confident = 0;  // of all these pixels: Γ > 0.5
  double share_supported = 0;
  double median = 0;            // where Γ > 0.5
  double p90 = 0;               // ...
  double share_wrong = 0;       // ... error > 5 %
  double median_supported = 0;  // where supported
  double p90_supported = 0;     // ...
  double share_accurate = 0;    // of all these pixels: error <= 1 % and Γ > 0.5
  // Mean error of each tenth of the supported pixels with Γ > 0, least confident first.
  std::array<double, 10> decile_error{};
  std::array<double, 10> decile_confidence{};  // largest Γ of the tenth
  int rising_deciles = 0;  // how often the mean error grows from one tenth to the next
};
enum class Pixels { kModel, kAllSurfaces };
AccuracyFigures MeasureAccuracy(const std::vector<ViewMesh>& views,
                                const std::vector<ViewTruth>& truth, Pixels pixels, int step);

// Depth discontinuities: neighbouring pixels whose true depths differ by more than 5 %, the nearer
// one on the model. Recalled: within 2 px the mesh has neighbouring pixels whose depths differ by
// more than half of that difference. Precision: of the mesh's own differences of more than 5 %
// (nearer pixel on the model), those with a true one of more than 2.5 % within 2 px.
struct EdgeFigures {
  double recall = 0;
  double precision = 0;
};
EdgeFigures MeasureDepthEdges(const std::vector<ViewMesh>& views,
                              const std::vector<ViewTruth>& truth);

}  // namespace colmap_ext
