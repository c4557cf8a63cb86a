#include "descriptor_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace colmap_ext {
namespace {

// Descriptors are taken a word of 32 bits at a time. Two components of 16 bits: the processor
// multiplies and adds such pairs into 32 bits in one instruction (128 * 255^2 < 2^31: nothing can
// overflow). Or, with VNNI, four components of 8 bits.
constexpr int kPairWords = kDescriptorSize / 2;
constexpr int kQuadWords = kDescriptorSize / 4;
constexpr int kRows = 4;    // descriptors of the first photo in one block
constexpr int kLanes = 16;  // step in which padded rows of products are searched

using Word = std::int32_t;

Word PairWord(const std::uint8_t* bytes) {
  return static_cast<Word>(bytes[0]) | (static_cast<Word>(bytes[1]) << 16);
}

Word QuadWord(const std::uint8_t* bytes) {
  Word word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  return word;
}

// VNNI multiplies unsigned by signed bytes: b becomes b - 128, and 128 times the sum of the other
// descriptor is added again.
constexpr int kSignedOffset = 128;
Word SignedQuadWord(const std::uint8_t* bytes) {
  return QuadWord(bytes) ^ static_cast<Word>(0x80808080U);
}

int RoundUp(int value, int step) { return (value + step - 1) / step * step; }

const std::uint8_t* DescriptorAt(const DescriptorView& view, int i) {
  return view.bytes + static_cast<std::ptrdiff_t>(i) * kDescriptorSize;
}

// [row][word], rows padded with zeros to full blocks.
std::vector<Word> PackPairRows(const DescriptorView& view) {
  std::vector<Word> words(static_cast<std::size_t>(RoundUp(view.count, kRows)) * kPairWords, 0);
  Word* word = words.data();
  for (int i = 0; i < view.count; ++i) {
    const std::uint8_t* bytes = DescriptorAt(view, i);
    for (int w = 0; w < kPairWords; ++w) *word++ = PairWord(bytes + 2 * w);
  }
  return words;
}

// The same, with the offset that its products begin with as one more word.
std::vector<Word> PackQuadRows(const DescriptorView& view) {
  std::vector<Word> words(static_cast<std::size_t>(RoundUp(view.count, kRows)) * (kQuadWords + 1),
                          0);
  Word* word = words.data();
  for (int i = 0; i < view.count; ++i) {
    const std::uint8_t* bytes = DescriptorAt(view, i);
    for (int w = 0; w < kQuadWords; ++w) *word++ = QuadWord(bytes + 4 * w);
    *word++ = kSignedOffset * std::accumulate(bytes, bytes + kDescriptorSize, 0);
  }
  return words;
}

// [block][word][column], so that one load brings the same word of several descriptors. Padded with
// descriptors of zeros.
template <int kColumns, int kBytesPerWord>
std::vector<Word> PackColumns(const DescriptorView& view, Word (*pack)(const std::uint8_t*)) {
  constexpr int kWords = kDescriptorSize / kBytesPerWord;
  const std::uint8_t zeros[kBytesPerWord] = {};
  std::vector<Word> words(static_cast<std::size_t>(RoundUp(view.count, kColumns)) * kWords,
                          pack(zeros));
  for (int j = 0; j < view.count; ++j) {
    Word* block = words.data() + static_cast<std::ptrdiff_t>(j / kColumns) * kWords * kColumns;
    const std::uint8_t* bytes = DescriptorAt(view, j);
    for (int w = 0; w < kWords; ++w) {
      block[w * kColumns + j % kColumns] = pack(bytes + kBytesPerWord * w);
    }
  }
  return words;
}

constexpr int kPairColumns = 16;  // descriptors of the second photo in one block
constexpr int kQuadColumns = 64;

std::vector<Word> PackPairColumns(const DescriptorView& view) {
  return PackColumns<kPairColumns, 2>(view, PairWord);
}
std::vector<Word> PackQuadColumns(const DescriptorView& view) {
  return PackColumns<kQuadColumns, 4>(view, SignedQuadWord);
}

// dots[r * stride + c] = row r . column c for one block.
using BlockKernel = void (*)(const Word* rows, const Word* columns, std::int32_t* dots, int stride);

void BlockPortable(const Word* rows, const Word* columns, std::int32_t* dots, int stride) {
  for (int r = 0; r < kRows; ++r) {
    std::array<std::int32_t, kPairColumns> sum{};
    for (int w = 0; w < kPairWords; ++w) {
      const Word a = rows[r * kPairWords + w];
      for (int c = 0; c < kPairColumns; ++c) {
        const Word b = columns[w * kPairColumns + c];
        sum[static_cast<std::size_t>(c)] += (a & 0xffff) * (b & 0xffff) + (a >> 16) * (b >> 16);
      }
    }
    std::copy(sum.begin(), sum.end(), dots + static_cast<std::ptrdiff_t>(r) * stride);
  }
}

#if defined(__x86_64__)
void BlockSse2(const Word* rows, const Word* columns, std::int32_t* dots, int stride) {
  constexpr int kStep = 4;
  for (int half = 0; half < kPairColumns; half += 2 * kStep) {
    __m128i sum[kRows][2] = {};
    for (int w = 0; w < kPairWords; ++w) {
      const Word* column = columns + w * kPairColumns + half;
      const __m128i b0 = _mm_loadu_si128(reinterpret_cast<const __m128i*>(column));
      const __m128i b1 = _mm_loadu_si128(reinterpret_cast<const __m128i*>(column + kStep));
      for (int r = 0; r < kRows; ++r) {
        const __m128i a = _mm_set1_epi32(rows[r * kPairWords + w]);
        sum[r][0] = _mm_add_epi32(sum[r][0], _mm_madd_epi16(a, b0));
        sum[r][1] = _mm_add_epi32(sum[r][1], _mm_madd_epi16(a, b1));
      }
    }
    for (int r = 0; r < kRows; ++r) {
      std::int32_t* out = dots + static_cast<std::ptrdiff_t>(r) * stride + half;
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out), sum[r][0]);
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out + kStep), sum[r][1]);
    }
  }
}

__attribute__((target("avx2"))) void BlockAvx2(const Word* rows, const Word* columns,
                                               std::int32_t* dots, int stride) {
  constexpr int kStep = 8;
  __m256i sum[kRows][2] = {};
  for (int w = 0; w < kPairWords; ++w) {
    const Word* column = columns + w * kPairColumns;
    const __m256i b0 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(column));
    const __m256i b1 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(column + kStep));
    for (int r = 0; r < kRows; ++r) {
      const __m256i a = _mm256_set1_epi32(rows[r * kPairWords + w]);
      sum[r][0] = _mm256_add_epi32(sum[r][0], _mm256_madd_epi16(a, b0));
      sum[r][1] = _mm256_add_epi32(sum[r][1], _mm256_madd_epi16(a, b1));
    }
  }
  for (int r = 0; r < kRows; ++r) {
    std::int32_t* out = dots + static_cast<std::ptrdiff_t>(r) * stride;
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), sum[r][0]);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + kStep), sum[r][1]);
  }
}

__attribute__((target("avx512f,avx512vnni"))) void BlockVnni(const Word* rows, const Word* columns,
                                                             std::int32_t* dots, int stride) {
  constexpr int kStep = 16, kVectors = kQuadColumns / kStep, kRowWords = kQuadWords + 1;
  __m512i sum[kRows][kVectors];
  for (int r = 0; r < kRows; ++r) {
    for (__m512i& lanes : sum[r]) lanes = _mm512_set1_epi32(rows[r * kRowWords + kQuadWords]);
  }
  for (int w = 0; w < kQuadWords; ++w) {
    __m512i b[kVectors];
    for (int v = 0; v < kVectors; ++v) {
      b[v] = _mm512_loadu_si512(columns + w * kQuadColumns + v * kStep);
    }
    for (int r = 0; r < kRows; ++r) {
      const __m512i a = _mm512_set1_epi32(rows[r * kRowWords + w]);
      for (int v = 0; v < kVectors; ++v) sum[r][v] = _mm512_dpbusd_epi32(sum[r][v], a, b[v]);
    }
  }
  for (int r = 0; r < kRows; ++r) {
    std::int32_t* out = dots + static_cast<std::ptrdiff_t>(r) * stride;
    for (int v = 0; v < kVectors; ++v) _mm512_storeu_si512(out + v * kStep, sum[r][v]);
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

__attribute__((target("avx512f,prefer-vector-width=512"))) void UpdateAvx512(
    const std::int32_t* dots, int count, int first_index, int step, std::int32_t* best,
    std::int32_t* second, std::int32_t* index) {
  UpdateBody(dots, count, first_index, step, best, second, index);
}
#endif

// Best two over one row: lane by lane first, then over the lanes; ties go to the lowest index.
BestTwo BestOfRow(const std::int32_t* dots, int padded_count, UpdateFunction update) {
  std::array<std::int32_t, kLanes> best{}, second{}, index{};
  index.fill(-1);
  for (int j = 0; j < padded_count; j += kLanes) {
    update(dots + j, kLanes, j, 1, best.data(), second.data(), index.data());
  }
  BestTwo result;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
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

// One way to compute the products, and the layout that it reads.
struct Kernel {
  int row_words, columns, column_words;
  std::vector<Word> (*pack_rows)(const DescriptorView&);
  std::vector<Word> (*pack_columns)(const DescriptorView&);
  BlockKernel block;
  UpdateFunction update;
};

Kernel KernelFor(CpuPath path) {
  Kernel kernel = {kPairWords,      kPairColumns,  kPairWords,    PackPairRows,
                   PackPairColumns, BlockPortable, UpdatePortable};
#if defined(__x86_64__)
  if (path == CpuPath::kSse2) kernel.block = BlockSse2;
  if (path == CpuPath::kAvx2) {
    kernel.block = BlockAvx2;
    kernel.update = UpdateAvx2;
  }
  if (path == CpuPath::kAvx512Vnni) {
    return {kQuadWords + 1,  kQuadColumns, kQuadWords,  PackQuadRows,
            PackQuadColumns, BlockVnni,    UpdateAvx512};
  }
#endif
  (void)path;
  return kernel;
}

}  // namespace

std::vector<CpuPath> AvailableCpuPaths() {
  std::vector<CpuPath> paths = {CpuPath::kPortable};
#if defined(__x86_64__)
  paths.push_back(CpuPath::kSse2);  // part of every x86-64
  if (__builtin_cpu_supports("avx2")) paths.push_back(CpuPath::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vnni")) {
    paths.push_back(CpuPath::kAvx512Vnni);
  }
#endif
  return paths;
}

BestTwoBothWays FindBestTwo(const DescriptorView& first, const DescriptorView& second,
                            CpuPath path) {
  const Kernel kernel = KernelFor(path);
  const std::vector<Word> rows = kernel.pack_rows(first);
  const std::vector<Word> columns = kernel.pack_columns(second);
  const int padded = RoundUp(second.count, kernel.columns);
  std::vector<std::int32_t> dots(static_cast<std::size_t>(padded) * kRows);
  BestTwoArrays of_second(padded);
  BestTwoBothWays result;
  result.of_first.resize(static_cast<std::size_t>(first.count));
  for (int i = 0; i < first.count; i += kRows) {
    const Word* row_block = rows.data() + static_cast<std::ptrdiff_t>(i) * kernel.row_words;
    for (int j = 0; j < padded; j += kernel.columns) {
      kernel.block(row_block, columns.data() + static_cast<std::ptrdiff_t>(j) * kernel.column_words,
                   dots.data() + j, padded);
    }
    for (int r = 0; r < std::min(kRows, first.count - i); ++r) {
      const std::int32_t* row = dots.data() + static_cast<std::ptrdiff_t>(r) * padded;
      kernel.update(row, padded, i + r, 0, of_second.best.data(), of_second.second.data(),
                    of_second.index.data());
      result.of_first[static_cast<std::size_t>(i + r)] = BestOfRow(row, padded, kernel.update);
    }
  }
  result.of_second.resize(static_cast<std::size_t>(second.count));
  for (std::size_t j = 0; j < result.of_second.size(); ++j) {
    result.of_second[j] = {of_second.best[j], of_second.second[j], of_second.index[j]};
  }
  return result;
}

}  // namespace colmap_ext
