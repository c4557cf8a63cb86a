// What the PLY reader and writer both know about number types.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "colmap_ext/scene/ply.h"

namespace colmap_ext {

static_assert(std::endian::native == std::endian::little,
              "binary PLY is read and written without swapping bytes");

inline std::size_t PlySize(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUInt8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUInt16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUInt32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

// The classic names, which every viewer knows ("uchar" rather than "uint8").
inline const char* PlyName(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
      return "char";
    case PlyType::kUInt8:
      return "uchar";
    case PlyType::kInt16:
      return "short";
    case PlyType::kUInt16:
      return "ushort";
    case PlyType::kInt32:
      return "int";
    case PlyType::kUInt32:
      return "uint";
    case PlyType::kFloat32:
      return "float";
    case PlyType::kFloat64:
      return "double";
  }
  return "";
}

inline std::optional<PlyType> PlyTypeFromName(std::string_view name) {
  if (name == "char" || name == "int8") return PlyType::kInt8;
  if (name == "uchar" || name == "uint8") return PlyType::kUInt8;
  if (name == "short" || name == "int16") return PlyType::kInt16;
  if (name == "ushort" || name == "uint16") return PlyType::kUInt16;
  if (name == "int" || name == "int32") return PlyType::kInt32;
  if (name == "uint" || name == "uint32") return PlyType::kUInt32;
  if (name == "float" || name == "float32") return PlyType::kFloat32;
  if (name == "double" || name == "float64") return PlyType::kFloat64;
  return std::nullopt;
}

inline bool IsPlyInteger(PlyType type) {
  return type != PlyType::kFloat32 && type != PlyType::kFloat64;
}

// Calls `use` with a value-initialised number of the C++ type that `type` stands for.
template <typename Use>
auto VisitPlyType(PlyType type, Use use) {
  switch (type) {
    case PlyType::kInt8:
      return use(std::int8_t{});
    case PlyType::kUInt8:
      return use(std::uint8_t{});
    case PlyType::kInt16:
      return use(std::int16_t{});
    case PlyType::kUInt16:
      return use(std::uint16_t{});
    case PlyType::kInt32:
      return use(std::int32_t{});
    case PlyType::kUInt32:
      return use(std::uint32_t{});
    case PlyType::kFloat32:
      return use(float{});
    case PlyType::kFloat64:
      break;
  }
  return use(double{});
}

// Whether `value` can be stored as `type`: whole and in range for an integer type.
inline bool FitsPlyType(double value, PlyType type) {
  if (!IsPlyInteger(type)) return true;
  return VisitPlyType(type, [value](auto number) {
    using Limits = std::numeric_limits<decltype(number)>;
    return value == std::floor(value) && value >= static_cast<double>(Limits::lowest()) &&
           value <= static_cast<double>(Limits::max());
  });
}

inline double LoadPlyNumber(const char* bytes, PlyType type) {
  return VisitPlyType(type, [bytes](auto number) {
    std::memcpy(&number, bytes, sizeof(number));
    return static_cast<double>(number);
  });
}

}  // namespace colmap_ext
