#pragma once

#include "colmap_ext/mvs/superpixel_stereo.h"
#include "support/bench_report.h"
#include "survey.h"

namespace colmap_ext {

// Tries values of σ_p, σ_n, σ_v and σ_c on the cues of the finished meshes, and reports, over
// pixels that see the model: with the options' values and with the grid's best, how well Γ tells
// accurate pixels (error at most 1 %) from others (area under the ROC curve), the share with Γ >
// 0.5, and the 90th percentile of the error there. Best: the largest share among those whose 90th
// percentile is at most 1 % and whose area is within 0.005 of the largest.
void ReportCalibration(const Survey& survey, const SuperpixelStereoResult& result,
                       const SuperpixelStereoOptions& options, BenchReport* report);

}  // namespace colmap_ext
