// Loops over all cores.
#pragma once

#include <tbb/parallel_for.h>

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace colmap_ext {

// What comes before a loop happens before its calls, and these before what comes after it. TBB sees
// to that, but ThreadSanitizer cannot know, for the library is not built with it: here it is told.
// Does nothing in other builds.
class LoopOrder {
 public:
  LoopOrder() { Release(); }
  void Close() { Acquire(); }

  // Around one call of the loop's body.
  class Call {
   public:
    explicit Call(LoopOrder& order) : order_(order) { order_.Acquire(); }
    ~Call() { order_.Release(); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    LoopOrder& order_;
  };

 private:
#if defined(__SANITIZE_THREAD__)
  void Acquire() { __tsan_acquire(this); }
  void Release() { __tsan_release(this); }
#else
  void Acquire() {}
  void Release() {}
#endif
};

// Calls body(0) … body(count - 1), in any order, on all cores that TBB may use. `body` is called
// from several threads at once. An exception of one of the calls ends the loop, and is thrown.
template <typename Index, typename Body>
void ParallelFor(Index count, const Body& body) {
  LoopOrder order;
  tbb::parallel_for(Index{0}, count, [&order, &body](Index i) {
    const LoopOrder::Call call(order);
    body(i);
  });
  order.Close();
}

}  // namespace colmap_ext
