#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "colmap_ext/report/report_page.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

struct KnownPicture {
  const char* stem;
  const char* title;
};

constexpr std::array kKnownPictures = {
    KnownPicture{"superpixels", "Photo with its superpixel mesh"},
    KnownPicture{"confidence", "Confidence of the fast stereo"},
    KnownPicture{"surface", "Surface"},
    KnownPicture{"coverage", "Coverage map"},
    KnownPicture{"path", "Flight path with the next views"},
};

std::size_t RankOf(const std::string& stem) {
  const auto* found =
      std::find_if(kKnownPictures.begin(), kKnownPictures.end(),
                   [&](const KnownPicture& picture) { return stem == picture.stem; });
  return static_cast<std::size_t>(found - kKnownPictures.begin());
}

std::vector<ReportPicture> PicturesIn(const fs::path& folder) {
  std::vector<ReportPicture> pictures;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_regular_file() || entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    const std::size_t rank = RankOf(stem);
    pictures.push_back(
        {rank < kKnownPictures.size() ? kKnownPictures[rank].title : stem, entry.path()});
  }
  std::sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) {
    return std::pair(RankOf(a.file.stem().string()), a.file) <
           std::pair(RankOf(b.file.stem().string()), b.file);
  });
  return pictures;
}

}  // namespace

std::vector<std::string> ReportPictureNames() {
  std::vector<std::string> names;
  for (const KnownPicture& picture : kKnownPictures) {
    names.push_back(std::string(picture.stem) + ".png");
  }
  return names;
}

ReportInput ReadReportInput(const Workspace& workspace) {
  RequireFolder(workspace.root(), "workspace");
  RequireFile(workspace.summary_json(), "summary of a session (run active_capture first)");
  ReportInput input;
  // "W" and "W/" are one workspace.
  const fs::path root = fs::absolute(workspace.root()).lexically_normal();
  input.title = (root.has_filename() ? root : root.parent_path()).filename().string();
  input.summary = ReadSummary(workspace.summary_json());
  for (std::size_t i = 0; i < input.summary.iterations.size(); ++i) {
    const IterationFiles files{workspace.iteration(static_cast<int>(i))};
    IterationSummary& iteration = input.summary.iterations[i];
    if (iteration.stage_wall_s.empty() && fs::exists(files.timing_json())) {
      iteration.stage_wall_s = ReadStageSeconds(files.timing_json());
    }
    input.pictures.push_back(PicturesIn(files.pictures()));
  }
  return input;
}

}  // namespace colmap_ext
