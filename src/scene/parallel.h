// Parallel work over files, with errors that do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <exception>
#include <vector>

#include "colmap_ext/util/parallel.h"

namespace colmap_ext {

// Calls work(0) … work(count - 1) in parallel. All are called; then the exception of the lowest
// index that threw, if any, is thrown.
template <typename Work>
void ParallelForEach(std::size_t count, const Work& work) {
  std::vector<std::exception_ptr> failures(count);
  ParallelFor(count, [&](std::size_t i) {
    try {
      work(i);
    } catch (...) {
      failures[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace colmap_ext
