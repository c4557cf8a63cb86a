// Any bytes in place of a model's file: the readers answer with a sound model or with one Error
// that names the folder, and never crash. The loop is deterministic; FuzzModelFile has the form
// that a fuzzer calls.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/util/files.h"
#include "scene/colmap_tool.h"
#include "scene/sparse_model.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// True when the model was read.
bool FuzzModelFile(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  try {
    CheckConsistency(ReadReconstruction(path.parent_path()), "what was read");
    return true;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_HAS(message, path.parent_path().string());
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return false;
  }
}

// One of: a bit turned over, a number made extreme, a cut, a part repeated, a part removed.
std::string Damaged(std::string bytes, std::mt19937_64& random) {
  const std::size_t at = random() % bytes.size();
  const std::size_t length = std::min<std::size_t>(1 + random() % 40, bytes.size() - at);
  switch (random() % 5) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
      break;
    case 1: {
      static constexpr std::uint64_t kExtreme[] = {0,
                                                   1,
                                                   0x7fffffff,
                                                   0xffffffff,
                                                   0x7ff8000000000000,
                                                   0x7ff0000000000000,
                                                   0x8000000000000000,
                                                   0xffffffffffffffff};
      const std::uint64_t value = kExtreme[random() % std::size(kExtreme)];
      std::memcpy(bytes.data() + at, &value, std::min<std::size_t>(8, bytes.size() - at));
      break;
    }
    case 2:
      bytes.resize(at);
      break;
    case 3:
      bytes.insert(at, bytes.substr(at, length));
      break;
    default:
      bytes.erase(at, length);
  }
  return bytes;
}

class MutatedModel : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Models, MutatedModel, testing::Values("bin", "txt"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(MutatedModel, IsReadSoundOrRefusedWithOneLine) {
  TestFolder folder;
  Reconstruction model = MakeSparseModel(4, 6);
  model.frame_table = FrameTableOf(model);
  const fs::path place = folder / "model";
  if (GetParam() == std::string("bin")) {
    WriteReconstructionBinary(model, place);
  } else {
    WriteReconstructionText(model, place);
  }
  std::mt19937_64 random(17);
  int num_refused = 0;
  for (const char* stem : {"cameras.", "images.", "points3D.", "rigs.", "frames."}) {
    const fs::path path = place / (std::string(stem) + GetParam());
    const std::string sound = ReadFile(path);
    for (int i = 0; i < 250; ++i) num_refused += !FuzzModelFile(path, Damaged(sound, random));
    for (int i = 0; i < 50; ++i) {  // damage upon damage
      num_refused += !FuzzModelFile(path, Damaged(Damaged(sound, random) + "x", random));
    }
    EXPECT_FALSE(FuzzModelFile(path, "x"));
    EXPECT_TRUE(FuzzModelFile(path, sound));
  }
  EXPECT_GT(num_refused, 500);
}

}  // namespace
}  // namespace colmap_ext
