// Times of the operating system as seconds.
#pragma once

#include <sys/time.h>

namespace colmap_ext {

inline double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace colmap_ext
