#pragma once

#include <optional>
#include <string>

namespace colmap_ext {

enum class Pattern {
  kGridDownward,
  kGridMultiAngle,
  kCircles,
  kRectangleSparse,
  kRectangleDense,
  kInitialRectangle,
};

// Any case, '_' as good as '-'.
std::optional<Pattern> FindPattern(const std::string& name);

}  // namespace colmap_ext
