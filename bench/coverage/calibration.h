// Fits the constants of the predicted error.
#pragma once

#include <vector>

#include "judged.h"
#include "support/bench_report.h"

namespace colmap_ext {

// Logistic regression of "the true error is more than t pixels of the best view", for eight t from
// 0.1 to 4 at once, on the logarithms of stereo, scatter (bounded as in `model`) and views: the
// same weights for all t, so that one line of ln t says where the median lies. Every flight weighs
// the same. When stereo_exponent + scatter_exponent would exceed 1 it is fitted again with their
// sum at 1, and without the views when their exponent would be negative. Bounds and max_angle_deg
// stay as they are in `model`. The constants of the failure are those of the logistic regression of
// "the true error is more than 6 pixels of the best view" on the means around the points, none of a
// sign that would make a view more harmful.
ErrorModel FitErrorModel(const std::vector<JudgedFlight>& flights, const ErrorModel& model);

void ReportErrorModel(const std::string& name, const ErrorModel& model, BenchReport* report);

}  // namespace colmap_ext
