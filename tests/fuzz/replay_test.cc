// Every target with its kept corpus, and with mutations of it, the same in every run.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "colmap_ext/util/files.h"
#include "fuzz/targets.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using SeedBytes = std::vector<std::uint8_t>;

class Fuzz : public testing::TestWithParam<FuzzTarget> {
 protected:
  static std::vector<SeedBytes> Corpus() {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(fs::path(COLMAP_EXT_SOURCE_DIR) /
                                                    "tests/fuzz/corpus" / GetParam().name)) {
      files.push_back(entry.path());
    }
    std::ranges::sort(files);
    std::vector<SeedBytes> corpus;
    for (const fs::path& file : files) {
      const std::string content = ReadFile(file);
      corpus.emplace_back(content.begin(), content.end());
    }
    return corpus;
  }
};

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(AllFuzzTargets()),
                         [](const auto& info) { return info.param.name; });

void Mutate(std::mt19937_64* random, const std::vector<SeedBytes>& corpus, SeedBytes* bytes) {
  const auto at = [&](std::size_t size) { return (*random)() % (size + 1); };
  for (std::size_t changes = 1 + (*random)() % 8; changes > 0; --changes) {
    const std::size_t place = at(bytes->size());
    const auto position = bytes->begin() + static_cast<std::ptrdiff_t>(place);
    switch ((*random)() % 5) {
      case 0:
        if (place < bytes->size()) (*bytes)[place] ^= static_cast<std::uint8_t>(1U << at(7));
        break;
      case 1:
        if (place < bytes->size()) (*bytes)[place] = static_cast<std::uint8_t>((*random)());
        break;
      case 2:
        bytes->insert(position, static_cast<std::uint8_t>((*random)()));
        break;
      case 3:
        bytes->erase(position,
                     position + static_cast<std::ptrdiff_t>(at(bytes->size() - place) % 16));
        break;
      default: {
        const SeedBytes& other = corpus[(*random)() % corpus.size()];
        const std::size_t from = at(other.size());
        const std::size_t count = std::min<std::size_t>(at(other.size() - from), 300);
        bytes->insert(position, other.begin() + static_cast<std::ptrdiff_t>(from),
                      other.begin() + static_cast<std::ptrdiff_t>(from + count));
      }
    }
  }
  bytes->resize(std::min<std::size_t>(bytes->size(), 4096));
}

TEST_P(Fuzz, CorpusAndMutationsBreakNoPromise) {
  const std::vector<SeedBytes> corpus = Corpus();
  ASSERT_GE(corpus.size(), 3U);
  for (const SeedBytes& bytes : corpus) ASSERT_NO_THROW(GetParam().run(bytes));
  ASSERT_NO_THROW(GetParam().run({}));
  std::mt19937_64 random(1);
  for (int i = 0; i < GetParam().mutations; ++i) {
    SeedBytes bytes = corpus[random() % corpus.size()];
    Mutate(&random, corpus, &bytes);
    ASSERT_NO_THROW(GetParam().run(bytes)) << "mutation " << i;
  }
}

}  // namespace
}  // namespace colmap_ext
