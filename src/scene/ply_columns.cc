#include "scene/ply_columns.h"

#include <algorithm>
#include <cmath>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

const PlyElement& RequireElement(const PlyData& data, const std::string& name,
                                 const std::filesystem::path& path) {
  const PlyElement* element = data.FindElement(name);
  if (element == nullptr) throw Error(path.string() + ": the PLY file has no element " + name);
  return *element;
}

}  // namespace

ColumnReader::ColumnReader(const PlyData& data, const std::string& name, std::filesystem::path path)
    : element_(RequireElement(data, name, path)), path_(std::move(path)) {}

void ColumnReader::Fail(std::size_t row, const std::string& message) const {
  throw Error(path_.string() + ": " + element_.name + " " + std::to_string(row) + ": " + message);
}

bool ColumnReader::HasAll(const ColumnNames& names) const {
  return std::all_of(names.begin(), names.end(), [this](const char* name) { return Has(name); });
}

const std::vector<double>& ColumnReader::Numbers(const char* name) const {
  const PlyScalar* scalar = element_.FindScalar(name);
  if (scalar == nullptr) {
    throw Error(path_.string() + ": element " + element_.name + " has no property " + name);
  }
  for (std::size_t row = 0; row < element_.count; ++row) {
    if (!std::isfinite(scalar->values[row])) {
      Fail(row, std::string(name) + " is not a finite number");
    }
  }
  return scalar->values;
}

std::vector<int> ColumnReader::Integers(const char* name, int min, int max) const {
  const std::vector<double>& numbers = Numbers(name);
  std::vector<int> integers(numbers.size());
  for (std::size_t row = 0; row < numbers.size(); ++row) {
    const double value = numbers[row];
    if (value < min || value > max || value != std::floor(value)) {
      Fail(row, std::string(name) + " must be a whole number from " + std::to_string(min) + " to " +
                    std::to_string(max));
    }
    integers[row] = static_cast<int>(value);
  }
  return integers;
}

std::vector<Eigen::Vector3d> ColumnReader::Vectors(const ColumnNames& names) const {
  const std::vector<double>& x = Numbers(names[0]);
  const std::vector<double>& y = Numbers(names[1]);
  const std::vector<double>& z = Numbers(names[2]);
  std::vector<Eigen::Vector3d> vectors(NumRows());
  for (std::size_t row = 0; row < vectors.size(); ++row) vectors[row] = {x[row], y[row], z[row]};
  return vectors;
}

std::vector<Rgb8> ColumnReader::Colors() const {
  std::vector<Rgb8> colors(NumRows());
  for (int channel = 0; channel < 3; ++channel) {
    const std::vector<int> values =
        Integers(kColorColumns[static_cast<std::size_t>(channel)], 0, 255);
    for (std::size_t row = 0; row < values.size(); ++row) {
      colors[row][channel] = static_cast<std::uint8_t>(values[row]);
    }
  }
  return colors;
}

void AddNumbers(const char* name, PlyType type, std::vector<double> values, PlyElement* element) {
  element->scalars.push_back({.name = name, .type = type, .values = std::move(values)});
}

void AddVectors(const ColumnNames& names, const std::vector<Eigen::Vector3d>& vectors,
                PlyElement* element) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values(vectors.size());
    for (std::size_t row = 0; row < vectors.size(); ++row) values[row] = vectors[row][axis];
    AddNumbers(names[static_cast<std::size_t>(axis)], PlyType::kFloat64, std::move(values),
               element);
  }
}

void AddColors(const std::vector<Rgb8>& colors, PlyElement* element) {
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double> values(colors.size());
    for (std::size_t row = 0; row < colors.size(); ++row) values[row] = colors[row][channel];
    AddNumbers(kColorColumns[static_cast<std::size_t>(channel)], PlyType::kUInt8, std::move(values),
               element);
  }
}

Rgb8 QuantizedColor(const Eigen::Vector3d& color) {
  Rgb8 quantized;
  for (int channel = 0; channel < 3; ++channel) {
    const double value = std::isfinite(color[channel]) ? color[channel] : 0.0;
    quantized[channel] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
  }
  return quantized;
}

Eigen::Vector3d ColorFrom8Bit(const Rgb8& color) { return color.cast<double>() / 255.0; }

}  // namespace colmap_ext
