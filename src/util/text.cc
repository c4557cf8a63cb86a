#include "colmap_ext/util/text.h"

#include <cstdio>

namespace colmap_ext {

std::string FormatNumber(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace colmap_ext
