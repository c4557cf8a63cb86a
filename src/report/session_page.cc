#include "colmap_ext/report/session_page.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <system_error>
#include <vector>

#include "colmap_ext/report/report_page.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/util/child_process.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "report/html_text.h"
#include "report/page_data.h"
#include "report/page_photos.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Raised when the format of data/ changes, so that old files are written again.
constexpr int kPageFormat = 2;

constexpr const char* kAssetNames[] = {"page.html", "page.js", "page.css"};

bool HasAssets(const fs::path& folder) {
  return std::all_of(std::begin(kAssetNames), std::end(kAssetNames),
                     [&](const char* name) { return fs::is_regular_file(folder / name); });
}

// What a data file was made from: it is written again when this changes.
std::string StampOf(const std::vector<fs::path>& sources, int setting) {
  std::string stamp = std::to_string(kPageFormat) + " " + std::to_string(setting);
  for (const fs::path& source : sources) {
    std::error_code error;
    const auto size = fs::file_size(source, error);
    if (error) continue;
    const auto time = fs::last_write_time(source, error).time_since_epoch().count();
    stamp += " " + std::to_string(size) + ":" + std::to_string(time);
  }
  return stamp;
}

std::string FirstLine(const fs::path& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  return line;
}

struct DataFile {
  std::string key;   // "iteration/000"
  std::string link;  // "data/000.js"
  std::string stamp;
};

// Writes `colmapExt.put(key, content)`, a script that a page opened from a file may load. Returns
// the link to it, with the stamp's hash so that a browser does not show an old one; null when there
// is no content.
Json WriteDataFile(const DataFile& file, const fs::path& folder,
                   const std::function<std::string()>& content) {
  const fs::path path = folder / file.link;
  const std::string mark = "// " + file.stamp;
  if (!fs::exists(path) || FirstLine(path) != mark) {
    const std::string text = content();
    if (text.empty()) {
      std::error_code error;
      fs::remove(path, error);
      return nullptr;
    }
    WriteFileAtomically(path,
                        mark + "\ncolmapExt.put(" + Json(file.key).dump() + ", " + text + ");\n");
  }
  return file.link + "?" + std::to_string(std::hash<std::string>{}(file.stamp));
}

std::string DumpUnlessNull(const Json& json) { return json.is_null() ? "" : json.dump(); }

Json DataOfIteration(const std::string& number, const IterationFiles& files,
                     const PageOptions& options, const fs::path& folder) {
  const std::vector<fs::path> sources = {files.sparse() / "images.bin",
                                         files.sparse() / "points3D.bin",
                                         files.surface_ply(),
                                         files.coverage_ply(),
                                         files.coverage_json(),
                                         files.views_json(),
                                         files.path_json()};
  const fs::path overlays = files.folder / "overlays.json";
  return {
      {"scene",
       WriteDataFile({"iteration/" + number, "data/" + number + ".js", StampOf(sources, 0)}, folder,
                     [&] { return DumpUnlessNull(IterationForPage(files)); })},
      {"fused",
       WriteDataFile({"fused/" + number, "data/" + number + "_fused.js",
                      StampOf({files.fused_ply()}, options.max_points)},
                     folder,
                     [&] { return DumpUnlessNull(FusedCloudForPage(files, options.max_points)); })},
      {"overlays",
       WriteDataFile(
           {"overlays/" + number, "data/" + number + "_overlays.js", StampOf({overlays}, 0)},
           folder, [&] { return fs::exists(overlays) ? ReadFile(overlays) : std::string(); })}};
}

Json PicturesToJson(const std::vector<ReportPicture>& pictures, const std::string& number) {
  Json list = Json::array();
  for (const ReportPicture& picture : pictures) {
    list.push_back(
        {{"title", picture.title},
         {"link", "pictures/" + EncodeUrlPath(number + "_" + picture.file.filename().string())}});
  }
  return list;
}

Json SessionForPage(const ReportInput& input, const Workspace& workspace, const fs::path& folder,
                    const PageOptions& options, const JobControl& job) {
  Json iterations = SummaryToJson(input.summary)["iterations"];
  for (std::size_t i = 0; i < iterations.size(); ++i) {
    job.ThrowIfCancelled();
    const IterationFiles files{workspace.iteration(static_cast<int>(i))};
    const std::string number = files.folder.filename().string();
    iterations[i]["pictures"] = PicturesToJson(input.pictures[i], number);
    if (!fs::exists(files.sparse() / "images.bin")) continue;
    iterations[i]["data"] = DataOfIteration(number, files, options, folder);
  }
  return {{"title", input.title},
          {"finished", input.summary.finished},
          {"sentence", FinishedSentence(input.summary.finished)},
          {"photo_folder", PagePhotoFolder(options.photo_width_px)},
          {"iterations", iterations}};
}

// The template's two marks are replaced; everything else comes from data/session.js.
std::string FillTemplate(std::string html, const ReportInput& input) {
  const std::pair<const char*, std::string> marks[] = {
      {"{{TITLE}}", EscapeHtml(input.title)},
      {"{{STATUS}}", EscapeHtml(FinishedSentence(input.summary.finished))}};
  for (const auto& [mark, text] : marks) {
    for (auto at = html.find(mark); at != std::string::npos; at = html.find(mark, at)) {
      html.replace(at, std::string(mark).size(), text);
      at += text.size();
    }
  }
  return html;
}

void CopyIfChanged(const fs::path& source, const fs::path& target) {
  const std::string content = ReadFile(source);
  if (!fs::exists(target) || ReadFile(target) != content) WriteFileAtomically(target, content);
}

void WriteInteractivePage(const Workspace& workspace, const fs::path& folder,
                          const fs::path& image_path, const fs::path& assets,
                          const PageOptions& options, const JobControl& job) {
  const ReportInput input = ReadReportInput(workspace);
  for (const char* name : {"page.js", "page.css"}) {
    CopyIfChanged(assets / name, folder / "assets" / name);
  }
  const fs::path photos = image_path.empty() ? PhotoFolderOfWorkspace(workspace) : image_path;
  WritePagePhotos(workspace, photos, options.photo_width_px, folder, job);
  const Json session = SessionForPage(input, workspace, folder, options, job);
  WriteFileAtomically(folder / "data" / "session.js",
                      "colmapExt.put(\"session\", " + session.dump() + ");\n");
  WriteFileAtomically(folder / "index.html", FillTemplate(ReadFile(assets / "page.html"), input));
}

}  // namespace

std::string PageOptions::Check() const {
  if (photo_width_px < 64 || photo_width_px > 8192) {
    return "Page.photo_width_px must be 64 to 8192 (pixels)";
  }
  if (max_points < 0 || max_points > 4000000) return "Page.max_points must be 0 to 4000000";
  return "";
}

void BindOptions(OptionSet& set, PageOptions* options) {
  set.Add("Page", "assets_path", &options->assets_path,
          "folder of the page's scripts (page.html, page.js, page.css); empty: as installed");
  set.Add("Page", "photo_width_px", &options->photo_width_px,
          "photos on the page are at most this wide (px, 64 to 8192)");
  set.Add("Page", "max_points", &options->max_points,
          "points of the fused cloud that the page keeps of an iteration (0 to 4000000; 0: none)");
}

std::optional<fs::path> FindPageAssets(const fs::path& assets_path) {
  if (!assets_path.empty()) {
    if (HasAssets(assets_path)) return assets_path;
    throw Error(assets_path.string() +
                ": no page.html, page.js and page.css here (--Page.assets_path)");
  }
  const fs::path program_folder = FolderOfThisProgram();
  if (program_folder.empty()) return std::nullopt;
  const fs::path beside = program_folder.parent_path();
  for (const fs::path& folder : {beside / "share" / "colmap_ext" / "web", beside / "web"}) {
    if (HasAssets(folder)) return folder;
  }
  return std::nullopt;
}

void WriteSessionPage(const Workspace& workspace, const fs::path& folder,
                      const fs::path& image_path, const PageOptions& options,
                      const JobControl& job) {
  ThrowIfInvalid(options.Check());
  const auto assets = FindPageAssets(options.assets_path);
  if (!assets) {
    job.Warn(
        "the interactive page was not built (its build needs npm): writing the page of pictures "
        "and tables instead");
  }
  WriteReportPage(ReadReportInput(workspace), folder, assets ? "pictures.html" : "index.html");
  if (assets) WriteInteractivePage(workspace, folder, image_path, *assets, options, job);
}

}  // namespace colmap_ext
