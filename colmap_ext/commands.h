// The verbs of colmap_ext, one file cmd_<verb>.cc each. Register a new one in main.cc.
#pragma once

#include <atomic>
#include <string>
#include <vector>

namespace colmap_ext {

using Arguments = std::vector<std::string>;
using CancelFlag = std::atomic<bool>;

int RunSparseUpdater(const Arguments& arguments, const CancelFlag& cancel);
int RunSuperpixelSegmenter(const Arguments& arguments, const CancelFlag& cancel);
int RunSuperpixelStereo(const Arguments& arguments, const CancelFlag& cancel);
int RunSurfaceReconstructor(const Arguments& arguments, const CancelFlag& cancel);
int RunCoverageEvaluator(const Arguments& arguments, const CancelFlag& cancel);
int RunViewPlanner(const Arguments& arguments, const CancelFlag& cancel);
int RunPathPlanner(const Arguments& arguments, const CancelFlag& cancel);
int RunFlightPlanner(const Arguments& arguments, const CancelFlag& cancel);
int RunMissionExporter(const Arguments& arguments, const CancelFlag& cancel);
int RunActiveCapture(const Arguments& arguments, const CancelFlag& cancel);
int RunSceneRenderer(const Arguments& arguments, const CancelFlag& cancel);
int RunDenseReconstructor(const Arguments& arguments, const CancelFlag& cancel);
int RunModelEvaluator(const Arguments& arguments, const CancelFlag& cancel);
int RunReportGenerator(const Arguments& arguments, const CancelFlag& cancel);
int RunFlightClient(const Arguments& arguments, const CancelFlag& cancel);

}  // namespace colmap_ext
