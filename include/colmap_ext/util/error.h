// Errors that reach the user. A message is one line: what is wrong, where (file, line, image, row),
// and what to do about it.
#pragma once

#include <stdexcept>
#include <string>

namespace colmap_ext {

// Something could not be done. Programs print the message and exit with code 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The command line or an option is wrong. Programs print the message and exit with code 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

// The user asked to stop (Ctrl-C). Everything finished so far is on disk. Exit code 1.
class CancelledError : public Error {
 public:
  CancelledError() : Error("stopped on request; run the same command again to go on") {}
};

// Throws UsageError when an options struct's Check() returned a complaint (it is empty when all is
// well).
inline void ThrowIfInvalid(const std::string& complaint) {
  if (!complaint.empty()) throw UsageError(complaint);
}

}  // namespace colmap_ext
