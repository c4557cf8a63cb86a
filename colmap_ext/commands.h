// The verbs of colmap_ext, one file cmd_<verb>.cc each. Register a new one in main.cc.
#pragma once

#include <string>
#include <vector>

#include "program.h"

namespace colmap_ext {

using Arguments = std::vector<std::string>;

int RunSparseUpdater(const Arguments& arguments, Program& program);
int RunSuperpixelSegmenter(const Arguments& arguments, Program& program);
int RunSuperpixelStereo(const Arguments& arguments, Program& program);
int RunSurfaceReconstructor(const Arguments& arguments, Program& program);
int RunCoverageEvaluator(const Arguments& arguments, Program& program);
int RunViewPlanner(const Arguments& arguments, Program& program);
int RunPathPlanner(const Arguments& arguments, Program& program);
int RunFlightPlanner(const Arguments& arguments, Program& program);
int RunMissionExporter(const Arguments& arguments, Program& program);
int RunActiveCapture(const Arguments& arguments, Program& program);
int RunSceneRenderer(const Arguments& arguments, Program& program);
int RunDenseReconstructor(const Arguments& arguments, Program& program);
int RunModelEvaluator(const Arguments& arguments, Program& program);
int RunReportGenerator(const Arguments& arguments, Program& program);
int RunFlightClient(const Arguments& arguments, Program& program);

}  // namespace colmap_ext
