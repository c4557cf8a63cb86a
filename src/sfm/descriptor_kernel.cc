#include "descriptor_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace colmap_ext {
namespace {

// Descriptors are widened to 16 bits and taken two components at a time: the processor multiplies
// and adds such pairs into 32 bits in one instruction. 128 * 255^2 < 2^31: nothing can overflow.
constexpr int kNumWords = kDescriptorSize / 2;  // one word = two 16-bit components
constexpr int kRows = 4;                        // descriptors of the first photo in one block
constexpr int kColumns = 16;                    // ... of the second

using Word = std::int32_t;

Word PackWord(const std::uint8_t* bytes) {
  return static_cast<Word>(bytes[0]) | (static_cast<Word>(bytes[1]) << 16);
}

int RoundUp(int value, int step) { return (value + step - 1) / step * step; }

// [row][word], rows padded with zeros to full blocks.
std::vector<Word> PackRows(const DescriptorView& view) {
  const int rows = RoundUp(view.count, kRows);
  std::vector<Word> words(static_cast<std::size_t>(rows) * kNumWords, 0);
  for (int i = 0; i < view.count; ++i) {
    for (int w = 0; w < kNumWords; ++w) {
      words[static_cast<std::size_t>(i * kNumWords + w)] =
          PackWord(view.bytes + static_cast<std::ptrdiff_t>(i) * kDescriptorSize + 2 * w);
    }
  }
  return words;
}

// [block][word][column], so that one load brings the same word of several descriptors.
std::vector<Word> PackColumns(const DescriptorView& view) {
  const int columns = RoundUp(view.count, kColumns);
  std::vector<Word> words(static_cast<std::size_t>(columns) * kNumWords, 0);
  for (int j = 0; j < view.count; ++j) {
    Word* block = words.data() + static_cast<std::ptrdiff_t>(j / kColumns) * kNumWords * kColumns;
    for (int w = 0; w < kNumWords; ++w) {
      block[w * kColumns + j % kColumns] =
          PackWord(view.bytes + static_cast<std::ptrdiff_t>(j) * kDescriptorSize + 2 * w);
    }
  }
  return words;
}

// dots[r * stride + c] = row r . column c for one block. `rows`: kRows x kNumWords.
using BlockKernel = void (*)(const Word* rows, const Word* columns, std::int32_t* dots, int stride);

void BlockPortable(const Word* rows, const Word* columns, std::int32_t* dots, int stride) {
  for (int r = 0; r < kRows; ++r) {
    std::array<std::int32_t, kColumns> sum{};
    for (int w = 0; w < kNumWords; ++w) {
      const Word a = rows[r * kNumWords + w];
      for (int c = 0; c < kColumns; ++c) {
        const Word b = columns[w * kColumns + c];
        sum[static_cast<std::size_t>(c)] += (a & 0xffff) * (b & 0xffff) + (a >> 16) * (b >> 16);
      }
    }
    std::copy(sum.begin(), sum.end(), dots + static_cast<std::ptrdiff_t>(r) * stride);
  }
}

#if defined(__x86_64__)
void BlockSse2(const Word* rows, const Word* columns, std::int32_t* dots, int stride) {
  constexpr int kLanes = 4;
  for (int half = 0; half < kColumns; half += 2 * kLanes) {
    __m128i sum[kRows][2] = {};
    for (int w = 0; w < kNumWords; ++w) {
      const Word* column = columns + w * kColumns + half;
      const __m128i b0 = _mm_loadu_si128(reinterpret_cast<const __m128i*>(column));
      const __m128i b1 = _mm_loadu_si128(reinterpret_cast<const __m128i*>(column + kLanes));
      for (int r = 0; r < kRows; ++r) {
        const __m128i a = _mm_set1_epi32(rows[r * kNumWords + w]);
        sum[r][0] = _mm_add_epi32(sum[r][0], _mm_madd_epi16(a, b0));
        sum[r][1] = _mm_add_epi32(sum[r][1], _mm_madd_epi16(a, b1));
      }
    }
    for (int r = 0; r < kRows; ++r) {
      std::int32_t* out = dots + static_cast<std::ptrdiff_t>(r) * stride + half;
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out), sum[r][0]);
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out + kLanes), sum[r][1]);
    }
  }
}

__attribute__((target("avx2"))) void BlockAvx2(const Word* rows, const Word* columns,
                                               std::int32_t* dots, int stride) {
  constexpr int kLanes = 8;
  __m256i sum[kRows][2] = {};
  for (int w = 0; w < kNumWords; ++w) {
    const Word* column = columns + w * kColumns;
    const __m256i b0 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(column));
    const __m256i b1 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(column + kLanes));
    for (int r = 0; r < kRows; ++r) {
      const __m256i a = _mm256_set1_epi32(rows[r * kNumWords + w]);
      sum[r][0] = _mm256_add_epi32(sum[r][0], _mm256_madd_epi16(a, b0));
      sum[r][1] = _mm256_add_epi32(sum[r][1], _mm256_madd_epi16(a, b1));
    }
  }
  for (int r = 0; r < kRows; ++r) {
    std::int32_t* out = dots + static_cast<std::ptrdiff_t>(r) * stride;
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), sum[r][0]);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + kLanes), sum[r][1]);
  }
}
#endif

// The best two, one array a field so that the compiler can use vector instructions.
struct BestTwoArrays {
  explicit BestTwoArrays(int count)
      : best(static_cast<std::size_t>(count), 0),
        second(static_cast<std::size_t>(count), 0),
        index(static_cast<std::size_t>(count), -1) {}
  std::vector<std::int32_t> best, second, index;
};

// Elementwise: candidate j has product dots[j]; its index is first_index + step * j.
inline __attribute__((always_inline)) void UpdateBody(const std::int32_t* dots, int count,
                                                      int first_index, int step, std::int32_t* best,
                                                      std::int32_t* second, std::int32_t* index) {
  for (int j = 0; j < count; ++j) {
    const std::int32_t dot = dots[j];
    const std::int32_t old = best[j];
    second[j] = std::max(second[j], std::min(old, dot));
    index[j] = dot > old ? first_index + step * j : index[j];
    best[j] = std::max(old, dot);
  }
}

using UpdateFunction = void (*)(const std::int32_t*, int, int, int, std::int32_t*, std::int32_t*,
                                std::int32_t*);

void UpdatePortable(const std::int32_t* dots, int count, int first_index, int step,
                    std::int32_t* best, std::int32_t* second, std::int32_t* index) {
  UpdateBody(dots, count, first_index, step, best, second, index);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void UpdateAvx2(const std::int32_t* dots, int count,
                                                int first_index, int step, std::int32_t* best,
                                                std::int32_t* second, std::int32_t* index) {
  UpdateBody(dots, count, first_index, step, best, second, index);
}
#endif

// Best two over one row: lane by lane first, then over the lanes; ties go to the lowest index.
BestTwo BestOfRow(const std::int32_t* dots, int padded_count, UpdateFunction update) {
  std::array<std::int32_t, kColumns> best{}, second{}, index{};
  index.fill(-1);
  for (int j = 0; j < padded_count; j += kColumns) {
    update(dots + j, kColumns, j, 1, best.data(), second.data(), index.data());
  }
  BestTwo result;
  for (std::size_t lane = 0; lane < kColumns; ++lane) {
    const bool wins = best[lane] > result.best ||
                      (best[lane] == result.best && index[lane] >= 0 && index[lane] < result.index);
    if (wins) {
      result.second = std::max(result.best, second[lane]);
      result.best = best[lane];
      result.index = index[lane];
    } else {
      result.second = std::max(result.second, best[lane]);
    }
  }
  return result;
}

struct Functions {
  BlockKernel block;
  UpdateFunction update;
};

Functions FunctionsFor(CpuPath path) {
#if defined(__x86_64__)
  if (path == CpuPath::kAvx2) return {BlockAvx2, UpdateAvx2};
  if (path == CpuPath::kSse2) return {BlockSse2, UpdatePortable};
#endif
  (void)path;
  return {BlockPortable, UpdatePortable};
}

}  // namespace

std::vector<CpuPath> AvailableCpuPaths() {
  std::vector<CpuPath> paths = {CpuPath::kPortable};
#if defined(__x86_64__)
  paths.push_back(CpuPath::kSse2);  // part of every x86-64
  if (__builtin_cpu_supports("avx2")) paths.push_back(CpuPath::kAvx2);
#endif
  return paths;
}

BestTwoBothWays FindBestTwo(const DescriptorView& first, const DescriptorView& second,
                            CpuPath path) {
  const Functions functions = FunctionsFor(path);
  const std::vector<Word> rows = PackRows(first);
  const std::vector<Word> columns = PackColumns(second);
  const int padded = RoundUp(second.count, kColumns);
  std::vector<std::int32_t> dots(static_cast<std::size_t>(padded) * kRows);
  BestTwoArrays of_second(padded);
  BestTwoBothWays result;
  result.of_first.resize(static_cast<std::size_t>(first.count));
  for (int i = 0; i < first.count; i += kRows) {
    const Word* row_block = rows.data() + static_cast<std::ptrdiff_t>(i) * kNumWords;
    for (int j = 0; j < padded; j += kColumns) {
      functions.block(row_block, columns.data() + static_cast<std::ptrdiff_t>(j) * kNumWords,
                      dots.data() + j, padded);
    }
    for (int r = 0; r < std::min(kRows, first.count - i); ++r) {
      const std::int32_t* row = dots.data() + static_cast<std::ptrdiff_t>(r) * padded;
      functions.update(row, padded, i + r, 0, of_second.best.data(), of_second.second.data(),
                       of_second.index.data());
      result.of_first[static_cast<std::size_t>(i + r)] = BestOfRow(row, padded, functions.update);
    }
  }
  result.of_second.resize(static_cast<std::size_t>(second.count));
  for (std::size_t j = 0; j < result.of_second.size(); ++j) {
    result.of_second[j] = {of_second.best[j], of_second.second[j], of_second.index[j]};
  }
  return result;
}

}  // namespace colmap_ext
