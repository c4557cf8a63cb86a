// Columns of a PLY element as vectors and colours, and back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/scene/ply.h"

namespace colmap_ext {

using Rgb8 = Eigen::Matrix<std::uint8_t, 3, 1>;
using ColumnNames = std::array<const char*, 3>;

inline constexpr ColumnNames kPositionColumns = {"x", "y", "z"};
inline constexpr ColumnNames kNormalColumns = {"nx", "ny", "nz"};
inline constexpr ColumnNames kColorColumns = {"red", "green", "blue"};

// Reads columns of one element; every error names the file, and the row or property.
class ColumnReader {
 public:
  // Throws Error when `data` has no element `name`. `data` must outlive this object.
  ColumnReader(const PlyData& data, const std::string& name, std::filesystem::path path);

  std::size_t NumRows() const { return element_.count; }
  bool Has(const char* name) const { return element_.FindScalar(name) != nullptr; }
  bool HasAll(const ColumnNames& names) const;
  // Throws Error when the property is not there or holds a number that is not finite.
  const std::vector<double>& Numbers(const char* name) const;
  // The same, and every value must be a whole number from `min` to `max`.
  std::vector<int> Integers(const char* name, int min, int max) const;
  std::vector<Eigen::Vector3d> Vectors(const ColumnNames& names) const;
  // Throws Error when the colours are not 8 bit.
  std::vector<Rgb8> Colors() const;

  [[noreturn]] void Fail(std::size_t row, const std::string& message) const;

 private:
  const PlyElement& element_;
  std::filesystem::path path_;
};

void AddNumbers(const char* name, PlyType type, std::vector<double> values, PlyElement* element);
void AddVectors(const ColumnNames& names, const std::vector<Eigen::Vector3d>& vectors,
                PlyElement* element);
void AddColors(const std::vector<Rgb8>& colors, PlyElement* element);

// RGB 0 … 1 to 8 bit (rounded, clamped) and back.
Rgb8 QuantizedColor(const Eigen::Vector3d& color);
Eigen::Vector3d ColorFrom8Bit(const Rgb8& color);

}  // namespace colmap_ext
