// A question that only a typed "yes" answers.
#pragma once

#include <string>

#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Prints `text` and the question, and waits for a line on standard input. False: another answer, or
// the end of input. Throws CancelledError as soon as the user asks to stop.
bool AskYes(const std::string& text, const JobControl& job);

}  // namespace colmap_ext
