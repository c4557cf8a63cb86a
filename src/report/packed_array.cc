#include "report/packed_array.h"

#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

void AppendVarint(std::uint64_t value, std::string* bytes) {
  while (value >= 0x80) {
    bytes->push_back(static_cast<char>((value & 0x7f) | 0x80));
    value >>= 7;
  }
  bytes->push_back(static_cast<char>(value));
}

std::uint64_t Zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}

std::string Deflate(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), 6) != Z_OK) {
    throw Error("page: cannot compress an array of " + std::to_string(bytes.size()) + " bytes");
  }
  packed.resize(size);
  return packed;
}

std::string Base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // and EVP's closing zero
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

// Every third bit of the result, from the lowest 21 of `value`.
std::uint64_t SpreadBits(std::uint64_t value) {
  value = (value | value << 32) & 0x1f00000000ffff;
  value = (value | value << 16) & 0x1f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  return (value | value << 2) & 0x1249249249249249;
}

}  // namespace

Json PackIntegers(std::span<const std::int32_t> values, int components) {
  const auto stride = static_cast<std::size_t>(components);
  if (components < 1 || values.size() % stride != 0) {
    throw Error("page: " + std::to_string(values.size()) + " values are not rows of " +
                std::to_string(components));
  }
  std::string bytes;
  bytes.reserve(2 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::int64_t before = i < stride ? 0 : values[i - stride];
    AppendVarint(Zigzag(values[i] - before), &bytes);
  }
  return {{"components", components},
          {"count", values.size() / stride},
          {"data", Base64(Deflate(bytes))}};
}

Json PackPositions(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin,
                   double step_m) {
  if (!(step_m > 0)) throw Error("page: the step of packed positions must be positive");
  constexpr double kLimit = 1 << 30;
  std::vector<std::int32_t> values;
  values.reserve(3 * points.size());
  for (const Eigen::Vector3d& point : points) {
    for (int k = 0; k < 3; ++k) {
      const double steps = (point[k] - origin[k]) / step_m;
      values.push_back(static_cast<std::int32_t>(std::lround(std::clamp(steps, -kLimit, kLimit))));
    }
  }
  Json json = PackIntegers(values, 3);
  json["step"] = step_m;
  return json;
}

std::vector<std::size_t> SpatialOrder(const std::vector<Eigen::Vector3d>& points) {
  BoundingBox box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const double scale = points.empty() ? 0 : 2097151 / std::max(box.sizes().maxCoeff(), 1e-12);
  std::vector<std::uint64_t> code(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d cell = (points[i] - box.min()) * scale;
    for (int k = 0; k < 3; ++k) code[i] |= SpreadBits(static_cast<std::uint64_t>(cell[k])) << k;
  }
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return code[a] < code[b]; });
  return order;
}

}  // namespace colmap_ext
