// Our partition of photos beside SLIC's: time, and how well boundaries follow what is there.
#pragma once

#include "colmap_ext/mvs/superpixels.h"
#include "support/bench_report.h"
#include "survey.h"

namespace colmap_ext {

// Over every `every`-th photo. True boundaries: pixels on the model whose true depth differs from
// the next pixel's by more than 5 %, or where the true inverse depth, which is affine on a plane,
// turns by more than 1e-3 of itself a pixel. Recall: the share of them with a superpixel's boundary
// within 2 px. SLIC (OpenCV's ximgproc, on Lab, 10 iterations) makes about as many superpixels as
// ours.
void ReportPartition(const std::string& name, const Survey& survey,
                     const SuperpixelOptions& options, int every, BenchReport* report);

}  // namespace colmap_ext
