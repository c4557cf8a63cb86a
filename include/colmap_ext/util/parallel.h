// Loops over all cores.
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#else
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#endif

#include <vector>

namespace colmap_ext {

// Calls body(0) … body(count - 1), in any order, on all cores that TBB may use. `body` is called
// from several threads at once. An exception of one of the calls ends the loop, and is thrown.
#if defined(__SANITIZE_THREAD__)
// ThreadSanitizer cannot see what orders TBB's threads, whose packaged library is not built with
// it: its builds run the bodies on threads that it knows.
template <typename Index, typename Body>
void ParallelFor(Index count, const Body& body) {
  constexpr Index kThreads = 4;
  std::atomic<Index> next{0};
  std::mutex mutex;
  std::exception_ptr failure;  // the first one; guarded by `mutex`
  const auto run = [&] {
    try {
      for (Index i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> threads;
  for (Index t = 1; t < std::min(kThreads, count); ++t) threads.emplace_back(run);
  run();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}
template <typename Value>
void ParallelSort(std::vector<Value>* values) {
  std::sort(values->begin(), values->end());
}
#else
template <typename Index, typename Body>
void ParallelFor(Index count, const Body& body) {
  tbb::parallel_for(Index{0}, count, body);
}

// Sorts by operator<. Where the result must not depend on the number of threads, values that are
// equal must be the same in all that they hold.
template <typename Value>
void ParallelSort(std::vector<Value>* values) {
  tbb::parallel_sort(values->begin(), values->end());
}
#endif

}  // namespace colmap_ext
